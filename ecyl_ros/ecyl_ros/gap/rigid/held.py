"""Constants that the effort would have far off their sheet, and that no cause stands for.

Where the effort hardly follows the acceleration (a hand moves the output, a pendulum swings by its
weight, the rotor shakes in its backlash), an inertia next to nothing leaves least, whatever its
sheet says, and drags the values of all else along. No machine is like that: such a constant is held
within its tolerance, and the effects compete for what that leaves.
"""

from __future__ import annotations

from ...effects.catalogue import RIGID
from .judge import Judgement
from .sheet import sheet_values
from .void import SILENT


def unbelieved(judgement: Judgement) -> set[str]:
    """Effects that stand for such constants: beyond their tolerance without a cause, or with one
    that can be none."""
    contest, machine = judgement.contest, judgement.machine
    stated, linear = machine.half_widths(), machine.linear
    found = contest.winner.beyond.intersection(judgement.null.strained(contest.winner))
    for term in contest.order:
        known = RIGID[term.effect].constant[not linear] in stated
        if known and judgement.void(term) not in ("", *SILENT):
            found.add(term.effect)
    return found


def off_sheet(judgement: Judgement, effects: set[str]) -> list[str]:
    """How far these constants would be off, from what came out before they were held."""
    terms = [one for one in judgement.whole.terms if one.effect in effects]
    found = sheet_values(terms, judgement.spans, judgement.machine, judgement.units)
    off = [one for one in found if abs(one.pull) > 1.0]
    return [f"{one.parameter} to be {abs(one.pull):.1f} tolerances off its sheet" for one in off]


def said_of(judgement: Judgement, off: list[str]) -> str:
    """The note of constants that were held; off: see `off_sheet`."""
    return (
        f"the {judgement.motion.effort_name} asks for {' and '.join(off)}, and no cause stands for "
        "that: held within its tolerance. The effort hardly goes with the motion of such a "
        "machine: something that is not recorded moves the output, too, or parts are not rigid"
    )
