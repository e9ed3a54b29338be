"""What a recording measures of a rigid drive as a whole: the closest model, nominal and found."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from ...arrays import BoolArray, FloatArray
from ...effects import direction_dependent_friction as by_direction
from ...effects import load_coulomb_friction as coulomb
from ...effects import load_inertia_error as inertia
from ...effects import load_viscous_friction as viscous
from ...effects.along import Along
from ...effects.catalogue import RIGID
from ...effects.term import Interval, Term
from ..diagnosis import Measured
from .balance import Balance
from .beside import shown, with_more
from .gain_scale import GainScale
from .lower import where_inertia_holds
from .machine_values import machine_value, told_apart
from .other_friction import as_a_sum
from .solution import Solution
from .uncertainty import intervals


def measured(
    balance: Balance, along: Along, closest: Solution, *, named: Collection[str], floor: float
) -> tuple[Measured, ...]:
    """Nominal and found values together.

    closest: fit to all rows of the set whose values they are. named: keys of the terms that are
    causes; beside them then, what every machine may have and this one shows: friction of either
    kind, a load. Where nothing comes beside them, causes are measured as they are named. floor:
    standard deviation of what cannot be explained; what is left beyond it widens the intervals.
    """
    terms = list(closest.free)
    keys = {one.key for one in terms}
    refined = {name for one in terms for name in one.refines} | {one.effect for one in terms}
    # A wrong gain is told by what the file's constants ask: beside it they cannot be measured, too.
    relative = "gain" in keys and not along.motion.injected.any()
    known = [] if relative else _stated(along)
    extra = [
        one
        for one in known
        if one.key not in keys and not refined.intersection((one.effect, *one.refines))
    ]
    beside = shown(balance, along, closest, extra)
    extra += beside
    within, fit = where_inertia_holds(balance, along.machine, [*terms, *extra])
    told = intervals(balance, closest, balance.usable)
    scale = GainScale() if "gain" in keys else GainScale.of(_gain(balance, closest, extra), along)
    spans = intervals(within, fit, within.usable, fit.bends(within.usable, floor))
    sums, _ = as_a_sum(within, along, fit, spans)
    spans |= {
        one.key: [scale.scaled(at) for at in spans[one.key]] for one in fit.terms if one.of_effort
    }
    if not beside:  # nothing comes beside what is named: it is measured once
        spans |= {key: told[key] for key in named if key in spans and key != "inertia"}
    for key, first in sums.items():
        spans[key] = [spans[key][0].over(scale.scaled(first)), *spans[key][1:]]
    sheet = {
        RIGID[one.effect].constant[not along.machine.linear]
        for one in closest.terms
        if closest.known(one)
    }
    totals = (
        told_apart(one, total, named, beside, sheet, along, gain=scale.factor != 1.0)
        for one in fit.terms
        for span in spans[one.key]
        if (total := machine_value(one, span, along, keys)) is not None
    )
    rows = balance.usable
    rest = with_more(balance, closest, beside).residual[rows]
    return (*totals, relative_error(balance, rest, rows))


def _gain(balance: Balance, closest: Solution, extra: Sequence[Term]) -> Sequence[Interval] | None:
    """The gain within its tolerance, beside all that is measured by it; None where none is known.

    A wrong inertia of the file bends the gain as long as it is held to its own tolerance.
    """
    if not any(one.key == "gain" for one in closest.terms):
        return None
    return intervals(balance, with_more(balance, closest, extra), balance.usable)["gain"]


def _stated(along: Along) -> list[Term]:
    """Terms of the inertia and the friction that the file states."""
    model = along.model
    known = [] if _exact(along, inertia.term(along)) else [inertia.term(along)]
    friction = any(model.coulomb) and along.both_ways
    if friction and model.coulomb + model.viscous != model.coulomb[::-1] + model.viscous[::-1]:
        return [*known, by_direction.term(along)]
    known += [viscous.term(along)] if any(model.viscous) else []
    return [*known, *([coulomb.term(along)] if friction else [])]


def _exact(along: Along, term: Term) -> bool:
    """Whether the file states the constant that a term gives another value, and is sure of it."""
    machine = along.machine
    return machine.half_widths().get(RIGID[term.effect].constant[not machine.linear]) == 0.0


def relative_error(balance: Balance, left: FloatArray, rows: BoolArray) -> Measured:
    """What is left of the effort at `rows`, bool[m], over the effort there."""
    size = float(np.sqrt(np.mean(balance.effort[rows] ** 2)))
    share = float(np.sqrt(np.mean(left**2))) / size
    name = balance.motion.effort_name
    text = f"RMS of the residual over RMS of the {name}, over the whole run"
    return Measured(f"relative_{name}_error", "1", share, share, share, text)
