"""What was found, as a value of the whole machine, and how it differs from another of its name.

One report may hold three frictions: named as a cause, measured beside the causes, and a constant of
the sheet. The meaning of each says which it is.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace

from ...effects.along import Along
from ...effects.catalogue import RIGID
from ...effects.term import Interval, Term
from ..diagnosis import Measured

_OF_A_MOMENT = ("friction_drift", "local_jam")  # levels of a time or a place, not of the machine
_LOADED = "constant load included"  # in a friction's meaning: of either sign, then
ALL_THAT_MOVES = "all that moves"  # what an inertia or a mass is of


def machine_value(
    term: Term, span: Interval, along: Along, keys: Collection[str]
) -> Measured | None:
    """A value of the whole machine, what the file says with what was found; None for what is none.

    span: of the term's value. keys: of all terms that were fitted.
    """
    model, units = along.model, along.units
    if term.key in ("gain", "inertia") and span.low <= 0.0:
        return None  # not seen, or taken by what else is found
    if term.key == "gain":
        meaning = "output effort per unit of the signal"
        return Measured(*span, meaning, along.machine.gain)
    if term.key == "inertia":
        return Measured(*span, ALL_THAT_MOVES, model.inertia)
    load = model.constant if "constant" not in keys else 0.0
    viscous, level = "friction in proportion to speed", "friction level"
    totals = {
        units.per_speed("viscous"): (model.viscous[0], viscous),
        units.per_speed("viscous_positive"): (model.viscous[0], f"{viscous}, forwards"),
        units.per_speed("viscous_negative"): (model.viscous[1], f"{viscous}, backwards"),
        units.level("coulomb"): (model.coulomb[0], level),
        units.level("coulomb_positive"): (
            model.coulomb[0] + load,
            f"{level} forwards, {_LOADED}",
        ),
        units.level("coulomb_negative"): (
            model.coulomb[1] - load,
            f"{level} backwards, {_LOADED}",
        ),
    }
    if span.name in totals and term.effect not in _OF_A_MOMENT:
        base, meaning = totals[span.name]
        value, low, high = (one + base for one in span[2:])
        return Measured(span.name, span.unit, value, low, high, meaning, base or None)
    if term.effect == "constant_load":
        value, low, high = (one + model.constant for one in span[2:])
        nominal = model.constant or None
        return Measured(span.name, span.unit, value, low, high, "constant load", nominal)
    return None


def told_apart(
    term: Term,
    total: Measured,
    named: Collection[str],
    shown: Sequence[Term],
    sheet: Collection[str],
    along: Along,
    gain: bool,
) -> Measured:
    """A value with what tells it from another of its name in the same report.

    named: keys of the causes. shown: terms measured beside them. sheet: constants of the data sheet
    that are fitted within their tolerances. gain: whether efforts count by a gain that the sheet
    has pulled.
    """
    constant = RIGID[term.effect].constant[not along.machine.linear]
    if constant and constant in sheet:  # the table of the sheet has it within its tolerance
        apart = ", from the recording alone, without the sheet"
        if gain:
            apart = ", not held by the sheet, by the gain that the sheet allows"
    elif named and term.key not in named and term.key not in ("inertia", "gain"):
        apart = ", not named as a cause"
    elif shown and term.key in named:  # as a cause it was fitted without them
        apart = ", fitted beside values that are no causes"
    else:
        apart = ""
    if total.meaning.startswith("friction") and _LOADED not in total.meaning and total.high < 0.0:
        apart += "; negative, as no friction is: the model lacks something"
    return replace(total, meaning=total.meaning + apart)
