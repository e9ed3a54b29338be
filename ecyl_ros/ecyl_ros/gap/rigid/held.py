"""Constants that the effort would have far off their sheet, and that no cause stands for.

Where the effort hardly follows the acceleration (a hand moves the output, a pendulum swings by its
weight, the rotor shakes in its backlash), an inertia next to nothing leaves least, whatever its
sheet says, and drags the values of all else along. No machine is like that: such a constant is held
within its tolerance, and the effects compete for what that leaves.
"""

from __future__ import annotations

from ...effects.catalogue import RIGID
from ..report import quantities as q
from .judge import Judgement
from .sheet import sheet_values
from .void import SILENT


def unbelieved(judgement: Judgement) -> set[str]:
    """Effects that stand for such constants: nothing is named for what strains them, or what is
    can be no cause."""
    contest, machine = judgement.contest, judgement.machine
    stated, linear = machine.half_widths(), machine.linear
    found = set(judgement.null.strained(contest.winner))
    for term in contest.order:
        known = RIGID[term.effect].constant[not linear] in stated
        if known and judgement.void(term) not in ("", *SILENT):
            found.add(term.effect)
    return found


def said_of(judgement: Judgement, effects: set[str]) -> list[str]:
    """Notes of these constants, from what came out before they were held."""
    terms = [one for one in judgement.whole.terms if one.effect in effects]
    found = sheet_values(terms, judgement.spans, judgement.machine, judgement.units)
    effort = judgement.motion.effort_name
    return [
        f"the {effort} asks for {one.parameter} = {q.amount(one.value, one.unit)} where "
        f"{q.amount(one.nominal, one.unit)} is stated, and no cause stands for that: held within "
        "its tolerance. It hardly goes with the motion as a machine of this sheet would make it: "
        "something that is not recorded moves the output, too, or its parts are not rigid"
        for one in found
    ]
