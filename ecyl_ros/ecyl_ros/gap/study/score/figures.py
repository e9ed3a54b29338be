"""Every figure of a study in the order it is shown: one table, whatever drives it was drawn of."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from ..case import STRUCTURE, Case
from ..examine import Outcome
from .answers import (
    Judged,
    abstained,
    allowed,
    both_named,
    exactly_named,
    first_right,
    named_none,
    quiet,
    ruled,
    said_nothing_wrong,
)
from .figure import Figure, counted, quantile
from .laws import law_figures
from .parameters import parameter_errors, sheet_coverage
from .targets import targets

CONFIDENT = 0.9


def figures(judged: Sequence[Judged]) -> list[Figure]:
    """The study's figures beside what is wanted of them."""
    first = judged[0][0]
    wanted = targets(first.drives, first.sheet)

    def of(*kinds: str) -> list[Judged]:
        return [(case, outcome) for case, outcome in judged if case.kind in kinds]

    def seen(kind: str) -> list[Judged]:
        return [(case, outcome) for case, outcome in of(kind) if case.judgeable]

    def share(name: str, rows: Sequence[Judged], right: Callable[[Case, Outcome], bool]) -> Figure:
        return counted(name, [right(case, outcome) for case, outcome in rows], wanted.get(name))

    def middle(name: str, values: Sequence[float], unit: str, at: float = 0.5) -> Figure:
        up = name.startswith("shrink")
        return quantile(name, values, at, wanted.get(name), at_least=up, unit=unit)

    def plain(name: str, rights: Sequence[bool]) -> Figure:
        return counted(name, rights, wanted.get(name))

    single, pair, none = seen("single"), seen("pair"), of("none")
    inside, strangers = of("single", "pair"), of("outside", "withheld")
    hidden = [(case, outcome) for case, outcome in judged if not case.judgeable]
    faulty = [(case, out) for case, out in judged if case.kind != "none" and case.judgeable]
    errors = [entry for case, out in inside for entry in parameter_errors(case, out)]
    relative = [entry["relative"] for entry in errors if "relative" in entry]
    change = [entry["of_change"] for entry in errors if "relative" in entry]
    covered = [entry["covered"] for entry in errors if entry.get("covered") is not None]
    exact = [entry["exact"] for entry in errors if "exact" in entry]
    known = inside + none
    right = [(case, out) for case, out in known if exactly_named(case, out.named)]
    sure = [
        cause["effect"] in allowed(case)
        for case, out in judged
        for cause in out.causes
        if cause["confidence"] >= CONFIDENT
    ]
    seconds = [outcome.seconds for _, outcome in judged]
    return [
        share("single: named first", single, lambda c, o: first_right(c, o.named)),
        share("single: it alone named", single, lambda c, o: exactly_named(c, o.named)),
        share("pair: both named", pair, lambda c, o: both_named(c, o.named)),
        share("pair: both and no other", pair, lambda c, o: exactly_named(c, o.named)),
        share("no gap: no false alarm", none, lambda c, o: quiet(o)),
        share("   and it was judged", none, lambda c, o: ruled(o)),
        share("no gap: no cause named", none, lambda c, o: named_none(o)),
        share("no wrong cause named", judged, said_nothing_wrong),
        share("   where all can be named", known, said_nothing_wrong),
        share("   where it cannot be seen", hidden, said_nothing_wrong),
        share("not in catalogue: no wrong cause", strangers, said_nothing_wrong),
        share("   outside it", of("outside"), said_nothing_wrong),
        share("   withheld from it", of("withheld"), said_nothing_wrong),
        share("   and a gap reported", strangers, lambda c, o: abstained(o)),
        share(
            "beyond the contract: named first",
            of("beyond"),
            lambda c, o: first_right(c, o.named),
        ),
        share("block right", faulty, _block_right),
        middle("parameter error, median", relative, "%"),
        middle("   of the change from nominal", change, "%"),
        plain("   within the 95 % interval", covered),
        plain("   periods exact", exact),
        plain(
            "sheet: constants within interval",
            [one for case, out in right for one in sheet_coverage(case, out)],
        ),
        plain(
            "   whatever was named",
            [one for case, out in known for one in sheet_coverage(case, out)],
        ),
        middle("shrink held out, median", [_shrink(o) for _, o in single + pair], ""),
        plain(f"right of those at {CONFIDENT:g} or surer", sure),
        middle("seconds per case, median", seconds, "s"),
        middle("seconds per case: 90 % below", seconds, "s", 0.9),
        middle("seconds per case: all below", seconds, "s", 1.0),
        plain("diagnoses that ended", [o.error is None for _, o in judged]),
        *law_figures(judged),
        *_beside_structure(judged),
    ]


def _beside_structure(judged: Sequence[Judged]) -> list[Figure]:
    every = [(case, outcome) for case, outcome in judged if case.kind == STRUCTURE]
    if not every:
        return []
    seen = [(case, outcome) for case, outcome in every if case.judgeable]
    errors = [one.get("covered") for case, out in every for one in parameter_errors(case, out)]
    return [
        counted("beside structure: named first", [first_right(c, o.named) for c, o in seen], None),
        counted("   no wrong cause named", [said_nothing_wrong(c, o) for c, o in every], None),
        counted("   within the 95 % interval", [one for one in errors if one is not None], None),
    ]


def _shrink(outcome: Outcome) -> float:
    value = (outcome.diagnosis or {"gap": {}})["gap"].get("shrink")
    return float(value) if value is not None and math.isfinite(value) else 0.0


def _block_right(case: Case, outcome: Outcome) -> bool:
    location = (outcome.diagnosis or {}).get("location") or {}
    return location.get("block") in case.blocks
