"""Scoring opened cases against what was said of them: every figure of the study, as plain data."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from ...drive.parameters import DriveParameters
from .cases import EFFECTS, Case
from .inside import COUNTS, nominal_values
from .study import Outcome

CONFIDENT = 0.9
BINS = (0.0, 0.5, 0.7, 0.8, 0.9, 0.95, 0.99, 1.0)  # of the calibration curve
NOTHING = "(none)"
FAILED = "(failed)"


@dataclass(frozen=True)
class Figure:
    """One figure of the study beside what is wanted of it.

    Attributes:
        name: what a table calls it.
        value: NaN where the study holds no such case.
        right, count: where the figure is a share of cases or causes, else None and the number
            that went into it.
        wanted: bound; `at_least` says which way.
        unit: "%" for shares (kept as 0 to 1 here), "s", or "".
    """

    name: str
    value: float
    right: int | None
    count: int
    wanted: float | None
    at_least: bool = True
    unit: str = "%"

    @property
    def met(self) -> bool | None:
        """Whether the figure is what is wanted; None where there is nothing to compare."""
        if self.wanted is None or not math.isfinite(self.value):
            return None
        return self.value >= self.wanted if self.at_least else self.value <= self.wanted

    @property
    def interval(self) -> tuple[float, float] | None:
        """Wilson's 95 % interval of a share."""
        if self.right is None or not self.count:
            return None
        z, n, share = 1.96, self.count, self.right / self.count
        middle = (share + z * z / (2 * n)) / (1 + z * z / n)
        half = z / (1 + z * z / n) * math.sqrt(share * (1 - share) / n + z * z / (4 * n * n))
        return max(0.0, middle - half), min(1.0, middle + half)

    def as_json(self) -> dict[str, Any]:
        """Plain data; a value that is not there is null."""
        return {
            "name": self.name,
            "value": self.value if math.isfinite(self.value) else None,
            "right": self.right,
            "count": self.count,
            "ci95": list(self.interval) if self.interval else None,
            "wanted": self.wanted,
            "met": self.met,
        }


Judged = tuple[Case, Outcome]


def _counted(name: str, rights: Sequence[bool], wanted: float | None) -> Figure:
    count, right = len(rights), sum(rights)
    return Figure(name, right / count if count else math.nan, right, count, wanted)


def _share(
    name: str,
    judged: Iterable[Judged],
    right: Callable[[Case, Outcome], bool],
    wanted: float | None,
) -> Figure:
    return _counted(name, [right(case, outcome) for case, outcome in judged], wanted)


def _median(name: str, values: Sequence[float], wanted: float | None, **options: Any) -> Figure:
    middle = float(np.median(values)) if len(values) else math.nan
    return Figure(name, middle, None, len(values), wanted, **options)


def allowed(case: Case) -> set[str]:
    """Effects that may be named without being wrong: the case's own and what is akin to them."""
    akin = {name for effect in case.effects for name in EFFECTS[effect].akin}
    return case.names | akin


def first_right(case: Case, named: Sequence[str]) -> bool:
    """Whether the first name is (one of) the case's effects."""
    return bool(named) and named[0] in case.names


def both_named(case: Case, named: Sequence[str]) -> bool:
    """Whether every effect of the case is among the names."""
    return case.names <= set(named)


def exactly_named(case: Case, named: Sequence[str]) -> bool:
    """Whether the names are the case's effects, no more and no fewer."""
    return case.names == set(named)


def none_wrong(case: Case, named: Sequence[str]) -> bool:
    """Whether nothing is named that the case does not hold; naming nothing is never wrong."""
    return set(named) <= allowed(case)


def quiet(outcome: Outcome) -> bool:
    """Whether no gap was seen and none explained."""
    return outcome.diagnosis is not None and outcome.diagnosis["verdict"] == "no_gap"


def abstained(outcome: Outcome) -> bool:
    """Whether a gap was seen that was not, or not wholly, explained."""
    return outcome.diagnosis is not None and outcome.diagnosis["verdict"] in (
        "unexplained",
        "partly_explained",
    )


def parameter_errors(case: Case, outcome: Outcome, drive: DriveParameters) -> list[dict[str, Any]]:
    """One entry per parameter of each effect that was rightly named.

    relative: |said - true| / |true|; of_change: the same over |true - nominal| where the nominal
    model holds the quantity (a lead 0.2 % off is no feat if it was 0.4 % off before); covered:
    whether the 95 % interval holds the truth, None without one. Counts (periods) have `exact`
    instead.
    """
    nominal = nominal_values(drive)
    entries = []
    for cause in outcome.causes:
        true_values = case.effects.get(cause["effect"])
        if true_values is None:
            continue
        for parameter, true in true_values.items():
            said = cause["parameters"].get(parameter)
            value = math.nan if said is None else float(said["value"])
            entry: dict[str, Any] = {"effect": cause["effect"], "parameter": parameter}
            if parameter in COUNTS:
                entry["exact"] = abs(value - true) < 0.5
            else:
                error = abs(value - true) if math.isfinite(value) else math.inf
                change = abs(true - nominal.get((cause["effect"], parameter), 0.0))
                entry["relative"] = error / abs(true)
                entry["of_change"] = error / min(change, abs(true))
                interval = (said or {}).get("ci95")
                entry["covered"] = interval[0] <= true <= interval[1] if interval else None
            entries.append(entry)
    return entries


def _shrink(outcome: Outcome) -> float:
    value = (outcome.diagnosis or {"gap": {}})["gap"].get("shrink")
    return float(value) if value is not None and math.isfinite(value) else 0.0


def _block_right(case: Case, outcome: Outcome) -> bool:
    location = (outcome.diagnosis or {}).get("location") or {}
    return location.get("block") in case.blocks


def figures(judged: Sequence[Judged], drive: DriveParameters) -> list[Figure]:
    """The study's figures beside what is wanted, in the order they are shown."""

    def of(*kinds: str) -> list[Judged]:
        return [(case, outcome) for case, outcome in judged if case.kind in kinds]

    strangers, inside, faulty = (
        of("outside", "withheld"),
        of("single", "pair"),
        [(case, outcome) for case, outcome in judged if case.kind != "none"],
    )
    errors = [entry for case, out in inside for entry in parameter_errors(case, out, drive)]
    relative = [entry["relative"] for entry in errors if "relative" in entry]
    change = [entry["of_change"] for entry in errors if "relative" in entry]
    covered = [entry["covered"] for entry in errors if entry.get("covered") is not None]
    exact = [entry["exact"] for entry in errors if "exact" in entry]
    sure = [
        cause["effect"] in allowed(case)
        for case, out in judged
        for cause in out.causes
        if cause["confidence"] >= CONFIDENT
    ]

    return [
        _share("single: named first", of("single"), lambda c, o: first_right(c, o.named), 0.97),
        _share(
            "single: it alone named", of("single"), lambda c, o: exactly_named(c, o.named), None
        ),
        _share("pair: both named", of("pair"), lambda c, o: both_named(c, o.named), 0.9),
        _share("pair: both and no other", of("pair"), lambda c, o: exactly_named(c, o.named), None),
        _share("no gap: no false alarm", of("none"), lambda c, o: quiet(o), 1.0),
        _share("not in catalogue: no wrong cause", strangers, _said_nothing_wrong, 0.95),
        _share("   outside it", of("outside"), _said_nothing_wrong, None),
        _share("   withheld from it", of("withheld"), _said_nothing_wrong, None),
        _share("   and a gap reported", strangers, lambda c, o: abstained(o), None),
        _share(
            "beyond the contract: named first",
            of("beyond"),
            lambda c, o: first_right(c, o.named),
            None,
        ),
        _share("block right", faulty, _block_right, 0.97),
        _median("parameter error, median", relative, 0.03, at_least=False),
        _median("   of the change from nominal", change, None, at_least=False),
        _counted("   within the 95 % interval", covered, None),
        _counted("   periods exact", exact, None),
        _median("shrink held out, median", [_shrink(o) for _, o in inside], 0.95, unit=""),
        _counted(f"right of those at {CONFIDENT:g} or surer", sure, 0.95),
        _median(
            "seconds per case, median",
            [o.seconds for _, o in judged],
            30.0,
            at_least=False,
            unit="s",
        ),
        _counted("diagnoses that ended", [o.error is None for _, o in judged], 1.0),
    ]


def _said_nothing_wrong(case: Case, outcome: Outcome) -> bool:
    return outcome.diagnosis is not None and none_wrong(case, outcome.named)


def calibration(judged: Sequence[Judged]) -> list[dict[str, Any]]:
    """Causes by confidence: bounds of the bin, how many, their mean confidence, the share right."""
    said = [
        (float(cause["confidence"]), cause["effect"] in allowed(case))
        for case, outcome in judged
        for cause in outcome.causes
    ]
    curve = []
    for low, high in pairwise(BINS):
        last = high == BINS[-1]
        inside = [(c, right) for c, right in said if low <= c < high or (last and c == high)]
        share = _counted("", [right for _, right in inside], None)
        curve.append(
            {
                "from": low,
                "to": high,
                "count": share.count,
                "confidence": float(np.mean([c for c, _ in inside])) if inside else None,
                "right": share.value if inside else None,
                "ci95": list(share.interval) if share.interval else None,
            }
        )
    return curve


def confusion(judged: Sequence[Judged]) -> dict[str, dict[str, int]]:
    """For cases of one effect, by the true effect: how often each effect was named first."""
    table: dict[str, Counter[str]] = {}
    for case, outcome in judged:
        if case.kind in ("pair", "none"):
            continue
        said = FAILED if outcome.error else (outcome.named or [NOTHING])[0]
        for name in case.effects:
            note = " (withheld)" if name in case.withheld else ""
            row = name + (" (given)" if case.kind == "beyond" else note)
            table.setdefault(row, Counter())[said] += 1
    order = {name: index for index, name in enumerate(EFFECTS)}
    rows = sorted(table, key=lambda row: (row.endswith(")"), order[row.split(" ")[0]]))
    return {row: dict(table[row].most_common()) for row in rows}


def by_effect(judged: Sequence[Judged], drive: DriveParameters) -> dict[str, dict[str, Any]]:
    """For each catalogue effect of single and pair cases: how often it was there, was named, and
    the median relative error of its parameters."""
    table: dict[str, dict[str, Any]] = {}
    for name in EFFECTS:
        holding = [
            (case, out)
            for case, out in judged
            if name in case.effects and case.kind in ("single", "pair")
        ]
        if not holding:
            continue
        errors = [
            entry["relative"]
            for case, out in holding
            for entry in parameter_errors(case, out, drive)
            if entry["effect"] == name and "relative" in entry
        ]
        wrong = sum(name in out.named and name not in allowed(case) for case, out in judged)
        table[name] = {
            "single": sum(case.kind == "single" for case, _ in holding),
            "single_right": sum(
                first_right(case, out.named) for case, out in holding if case.kind == "single"
            ),
            "pair": sum(case.kind == "pair" for case, _ in holding),
            "pair_named": sum(name in out.named for case, out in holding if case.kind == "pair"),
            "named_wrongly": wrong,
            "error": float(np.median(errors)) if errors else None,
        }
    return table


def baseline_figures(judged: Sequence[Judged]) -> dict[str, dict[str, Any]]:
    """The same questions put to the baselines: shares, counts, and what they name most."""
    names = sorted({name for _, outcome in judged for name in outcome.baselines})
    report = {}
    for name in names:
        rows = [(c, o.baselines[name]["named"]) for c, o in judged if name in o.baselines]

        def share(right: Callable[[Case, Sequence[str]], bool], *kinds: str, rows=rows) -> Any:
            verdicts = [right(case, named) for case, named in rows if case.kind in kinds]
            return {"right": sum(verdicts), "count": len(verdicts)}

        report[name] = {
            "single: named first": share(first_right, "single"),
            "single: it alone named": share(exactly_named, "single"),
            "pair: both named": share(both_named, "pair"),
            "pair: both and no other": share(exactly_named, "pair"),
            "no gap: no false alarm": share(lambda c, named: not named, "none"),
            "not in catalogue: no wrong cause": share(none_wrong, "outside", "withheld"),
            "names_per_case": float(np.mean([len(named) for _, named in rows])),
            "named_first": dict(
                Counter((named or [NOTHING])[0] for _, named in rows).most_common()
            ),
            "seconds": float(
                np.median([o.baselines[name]["seconds"] for _, o in judged if o.baselines])
            ),
        }
    return report


def misjudged(judged: Sequence[Judged]) -> list[Judged]:
    """Cases whose diagnosis failed or named anything but what is there to be named."""
    return [
        (case, outcome)
        for case, outcome in judged
        if outcome.error
        or (case.kind == "none" and not quiet(outcome))
        or (case.kind in ("single", "pair", "beyond") and not exactly_named(case, outcome.named))
        or (case.kind in ("outside", "withheld") and not none_wrong(case, outcome.named))
    ]


def report(
    cases: Sequence[Case], outcomes: Sequence[Outcome], drive: DriveParameters
) -> dict[str, Any]:
    """Everything above as plain data."""
    judged = list(zip(cases, outcomes, strict=True))
    return {
        "figures": [figure.as_json() for figure in figures(judged, drive)],
        "verdicts": {
            kind: dict(
                Counter(
                    (o.diagnosis or {"verdict": FAILED})["verdict"]
                    for c, o in judged
                    if c.kind == kind
                )
            )
            for kind in dict.fromkeys(case.kind for case in cases)
        },
        "by_effect": by_effect(judged, drive),
        "calibration": calibration(judged),
        "confusion": confusion(judged),
        "baselines": baseline_figures(judged),
    }
