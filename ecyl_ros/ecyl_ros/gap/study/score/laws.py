"""Described causes against what was drawn: port, variables, curve, shrink; and laws invented."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..case import Case
from ..cylinder.law import VARIABLES, shape
from ..cylinder.unnamed import UNNAMED, Unnamed
from .answers import Judged, said_nothing_wrong
from .figure import Figure, counted, mean, quantile
from .own_curve import REPEATED, WITHIN, has_own_curve, off_own_curve

_PLACES = {"position", "rotor_angle", "screw_angle"}


def law_figures(judged: Sequence[Judged]) -> list[Figure]:
    """What was described: of laws without a name, of withheld effects, and beside the truth."""
    return [*_drawn_laws(judged), *_withheld(judged), *_invented(judged)]


def _invented(judged: Sequence[Judged]) -> list[Figure]:
    others = [outcome for case, outcome in judged if case.kind in ("single", "pair", "none")]
    if not others:
        return []
    none = [(outcome.diagnosis or {}).get("law") is None for outcome in others]
    return [counted("no law beside the truth", none, 0.98)]


def _withheld(judged: Sequence[Judged]) -> list[Figure]:
    laws = [
        (case, (outcome.diagnosis or {}).get("law"))
        for case, outcome in judged
        if has_own_curve(case)
    ]
    found = [(case, law) for case, law in laws if law is not None]
    if not laws:
        return []
    off = [off_own_curve(law, case) for case, law in found]
    return [
        counted("withheld: described", [law is not None for _, law in laws], None),
        counted(
            "withheld: its own curve, of those", [o is not None and o <= WITHIN for o in off], None
        ),
    ]


def _drawn_laws(judged: Sequence[Judged]) -> list[Figure]:
    drawn = [(case, outcome) for case, outcome in judged if case.kind == "law"]
    if not drawn:
        return []
    said = [((outcome.diagnosis or {}).get("law"), _kind(case), case) for case, outcome in drawn]
    found = [(law, kind, case) for law, kind, case in said if law is not None]
    inside = [share for law, kind, case in found if (share := covered(law, kind, case)) is not None]
    shrinks = {
        memory: [
            float(law["shrink"]) if law else 0.0 for law, kind, _ in said if kind.memory is memory
        ]
        for memory in (False, True)
    }
    return [
        counted("law: described", [law is not None for law, _, _ in said], None),
        counted(
            "law: port right, of those", [port_right(law, kind) for law, kind, _ in found], 0.95
        ),
        counted(
            "law: variables right, of those", [of_right(law, kind) for law, kind, _ in found], 0.9
        ),
        counted("law: no effect named wrongly", [said_nothing_wrong(c, o) for c, o in drawn], 0.97),
        quantile("law: shrink of static, median", shrinks[False], 0.5, 0.9),
        quantile("law: shrink of memory, median", shrinks[True], 0.5, 0.7),
        mean("law: of the curve in its band, mean", inside, 0.9, unit="%"),
    ]


def _kind(case: Case) -> Unnamed:
    (name,) = case.effects
    return UNNAMED[name]


def _side(port: str) -> str:
    """A drag is a torque at the same place."""
    return port.replace("friction", "torque")


def port_right(law: Mapping[str, Any], kind: Unnamed) -> bool:
    """Whether the law acts where the cause does."""
    return _side(law["port"]) == _side(kind.port)


def of_right(law: Mapping[str, Any], kind: Unnamed) -> bool:
    """Whether it depends on the same; an angle that never went round is a position."""
    turns = law["turns"]
    found, wanted = set(law["of"]), set(kind.of)
    if "speed" in found:
        found.discard("direction")
    if "speed" in wanted:
        wanted.discard("direction")
    once = {name for name in _PLACES if turns.get(name, 0.0) < REPEATED}
    return _merged(found, once) == _merged(wanted, once)


def _merged(names: set[str], once: set[str]) -> set[str]:
    return {"position" if one in once else one for one in names}


def truth(case: Case, of: Sequence[str], at: Sequence[np.ndarray]) -> np.ndarray | None:
    """The drawn law at places of its variables, float64[values]; None where others are given."""
    (values,) = case.effects.values()
    first = VARIABLES[int(values["first"])]
    second = VARIABLES[int(values["second"])] if "second_shape" in values else None
    drawn = [first] if second is None else [first, second]
    if set(drawn) != set(of):
        return None
    grids = dict(zip(of, np.meshgrid(*at, indexing="ij"), strict=True))

    def part(which: str, name: str) -> np.ndarray:
        number = int(values[f"{which}_shape"])
        width, place = values[f"{which}_width"], values[f"{which}_place"]
        flat = [shape(number, float(x), width, place) for x in grids[name].ravel()]
        return np.array(flat)

    found = values.get("offset", 0.0) + part("first", first)
    if second is not None:
        found = found * part("second", second)
    result: np.ndarray = values["size"] * found
    return result


def covered(law: Mapping[str, Any], kind: Unnamed, case: Case) -> float | None:
    """Share of what was visited over which the drawn curve lies within the law's 95 % band.

    None where the law is of other variables, or of a drag where a torque was drawn.
    """
    if law["port"] != kind.port or not law["of"]:
        return None
    at = [np.array(law["table"][key]) for key in ("at", "at_2")[: len(law["of"])]]
    true = truth(case, law["of"], at)
    if true is None:
        return None
    table = law["table"]
    values, half, seen = (np.array(table[key]) for key in ("values", "half_95", "seen"))
    if kind.port.endswith("friction"):
        true, values = np.maximum(true, 0.0), np.maximum(values, 0.0)
    if not seen.any():
        return None
    return float(np.mean(np.abs(values - true)[seen] <= half[seen]))


def law_lines(judged: Sequence[Judged]) -> list[str]:
    """What was drawn and what was described, a line a case."""
    lines = []
    for case, outcome in judged:
        if has_own_curve(case):
            lines.append(_own_curve_line(case, (outcome.diagnosis or {}).get("law")))
        if case.kind != "law":
            continue
        kind, law = _kind(case), (outcome.diagnosis or {}).get("law")
        drawn = f"{kind.name} at {kind.port} of {' and '.join(kind.of)}"
        if law is None:
            said = "not described"
        else:
            rights = [port_right(law, kind), of_right(law, kind)]
            marks = ", ".join(
                f"{'' if right else 'not '}{what}"
                for what, right in zip(("the port", "the variables"), rights, strict=True)
            )
            of = " and ".join(law["of"]) or "nothing"
            said = f"{law['port']} of {of}, shrink {law['shrink']:.3f}: {marks}"
            inside = covered(law, kind, case)
            said += "" if inside is None else f", {100.0 * inside:.0f} % of the curve in its band"
        lines.append(f"case {case.index} {drawn}: {said}")
    return lines


def _own_curve_line(case: Case, law: Mapping[str, Any] | None) -> str:
    said = "not described"
    if law is not None:
        off = off_own_curve(law, case)
        said = f"{law['port']} of {' and '.join(law['of']) or 'nothing'}, "
        said += "not its own curve" if off is None else f"off its own curve by {100.0 * off:.1f} %"
    return f"case {case.index} withheld {' and '.join(case.effects)}: {said}"
