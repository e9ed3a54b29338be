"""Constants that the effort would have off their sheet in a way that can be no cause.

Where the effort hardly follows the acceleration (a hand moves the output, a pendulum swings by its
weight, the rotor shakes in its backlash), an inertia next to nothing leaves least, whatever its
sheet says, and drags the values of all else along. No machine is like that: such a constant is held
within its tolerance, and the effects compete for what that leaves.
"""

from __future__ import annotations

from ...effects.catalogue import RIGID
from ..diagnosis import SheetValue
from .judge import Judgement, scales
from .sheet import sheet_values
from .void import SILENT


def unbelieved(judgement: Judgement) -> set[str]:
    """Effects that stand for such constants: as a cause they are void, or an inertia may be none.

    A constant that is off its sheet for a reason which the catalogue lacks is not among them: held,
    it would have to be made up for by what is no cause.
    """
    machine, null, winner = judgement.machine, judgement.null, judgement.contest.winner
    stated, linear = machine.half_widths(), machine.linear
    found = set[str]()
    for term in judgement.contest.order:
        known = RIGID[term.effect].constant[not linear] in stated
        if known and judgement.void(term) not in ("", *SILENT):
            found.add(term.effect)
    strained = winner.beyond.intersection(null.strained(winner))
    for term in judgement.values.fit.terms:
        if term.effect in strained and term.inertia:
            told = sheet_values([term], judgement.values.spans, machine, judgement.units)
            found.update(term.effect for one in told if one.low <= 0.0)
    return found


def gains_off(judgement: Judgement) -> set[str]:
    """Effects that stand for a gain of the effort which is off its sheet, as a cause or beside it.

    Times a larger gain the stated inertia is the smaller one: a gain that leaves its sheet only
    once an inertia is held makes up for that one, and is to be held as well.
    """
    off = {*judgement.null.strained(judgement.contest.winner)}
    off |= {one.effect for one in judgement.contest.order}
    return {one for one in off if scales(one)}


def off_sheet(judgement: Judgement, effects: set[str]) -> list[str]:
    """How far these constants would be off, from what came out before they were held."""
    terms = [one for one in judgement.values.fit.terms if one.effect in effects]
    found = sheet_values(terms, judgement.values.spans, judgement.machine, judgement.units)
    return [f"{one.parameter} to be {_how_far(one)}" for one in found if abs(one.pull) > 1.0]


def _how_far(value: SheetValue) -> str:
    if value.value <= 0.0 < value.nominal:  # its bound, however wide the tolerance is
        return "zero"
    return f"{abs(value.pull):.1f} tolerances off its sheet"


def said_of(judgement: Judgement, off: list[str]) -> str:
    """The note of constants that were held; off: see `off_sheet`."""
    return (
        f"the {judgement.motion.effort_name} asks for {' and '.join(off)}, which cannot be a cause "
        "here and was held within the tolerance: the effort hardly matches the motion. Something "
        "that is not recorded moves the output, too, or parts are not rigid"
    )
