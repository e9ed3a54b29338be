"""Whether one answer is right: the questions that a study puts to what was said of a case."""

from __future__ import annotations

from collections.abc import Sequence

from ...judge.verdict import STRUCTURELESS
from ..case import Case
from ..examine import Outcome

Judged = tuple[Case, Outcome]

GAP_LEFT = ("unexplained", "partly_explained", "described")
GAP = ("explained", *GAP_LEFT)


def allowed(case: Case) -> set[str]:
    """Effects that may be named without being wrong: the case's own and what is akin to them."""
    return case.names | case.akin


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


def said_nothing_wrong(case: Case, outcome: Outcome) -> bool:
    """Whether there was an answer, and it names nothing that the case does not hold."""
    return outcome.diagnosis is not None and none_wrong(case, outcome.named)


def quiet(outcome: Outcome) -> bool:
    """Whether there was an answer that reports no gap beyond what the sheet's tolerances allow.

    That nothing can be judged for noise raises no alarm (see `ruled`); that there is a gap whose
    causes look alike does.
    """
    if outcome.diagnosis is None:
        return False
    verdict, gap = outcome.diagnosis["verdict"], outcome.diagnosis["gap"]
    within_noise: bool = gap["before"] <= STRUCTURELESS * gap["floor"]
    return verdict not in GAP and (verdict != "not_judgeable" or within_noise)


def ruled(outcome: Outcome) -> bool:
    """Whether there was an answer that is more than that nothing can be judged."""
    return outcome.diagnosis is not None and outcome.diagnosis["verdict"] != "not_judgeable"


def named_none(outcome: Outcome) -> bool:
    """Whether there was an answer that names no cause."""
    return outcome.diagnosis is not None and not outcome.named


def abstained(outcome: Outcome) -> bool:
    """Whether a gap was seen that was not, or not wholly, explained."""
    return outcome.diagnosis is not None and outcome.diagnosis["verdict"] in GAP_LEFT


def misjudged(judged: Sequence[Judged]) -> list[Judged]:
    """Cases whose diagnosis failed or named anything but what is there to be named."""
    return [(case, outcome) for case, outcome in judged if not _right(case, outcome)]


def _right(case: Case, outcome: Outcome) -> bool:
    if outcome.diagnosis is None:
        return False
    if case.kind == "none":
        return quiet(outcome)
    if case.kind in ("outside", "withheld", "law") or not case.judgeable:
        return none_wrong(case, outcome.named)
    return exactly_named(case, outcome.named)
