"""A gain and further constants that would all be off their sheet by one factor.

Half the gain and half the inertia need the same effort: what is off then is the rest of what the
file states, by the inverse. Two faults that agree as closely as their tolerances let them are a
coincidence, one fault of the rest is none. Where that one has no name, or must not be named,
neither have they.
"""

from __future__ import annotations

import math

from ..diagnosis import SheetValue
from .judge import Judgement, scales
from .sheet import sheet_value


def of_one_factor(judgement: Judgement) -> dict[str, SheetValue]:
    """Such constants by the effects that stand for them, the gain first; none where none agrees."""
    causes = {one.key for one in judgement.contest.order}
    found = dict[str, SheetValue]()
    for term in judgement.values.fit.terms:
        if term.key in causes:
            spans = judgement.values.spans[term.key]
            told = sheet_value(term, spans, judgement.machine, judgement.units)
            if told is not None and told.value * told.nominal > 0.0:
                found[term.effect] = told
    gain = next((name for name in found if scales(name)), None)
    if gain is None:
        return {}
    alike = {
        name: one for name, one in found.items() if name != gain and off_by_one(one, found[gain])
    }
    return {gain: found[gain], **alike} if alike else {}


def off_by_one(one: SheetValue, other: SheetValue) -> bool:
    """Whether two constants are off by one factor, as far as sheet and recording know each."""
    apart = math.log(one.value / one.nominal) - math.log(other.value / other.nominal)
    by_sheet = (value.tolerance / abs(value.nominal) for value in (one, other))
    seen = (0.5 * (value.high - value.low) / abs(value.value) for value in (one, other))
    return abs(apart) <= math.hypot(*by_sheet, *seen)


def said_of_one_factor(found: dict[str, SheetValue]) -> str:
    """The note of such constants."""
    first = next(iter(found.values()))
    names = " and ".join(one.parameter for one in found.values())
    return (
        f"{names} would have to be off their sheet by one factor, {first.value / first.nominal:.2g}"
        ": independent faults seldom agree, and one in the rest of what the file states would "
        "look the same. None is named; each was held within its tolerance"
    )
