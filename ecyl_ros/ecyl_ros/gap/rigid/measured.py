"""The closest model of a rigid drive as a whole, and what its file leaves out."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ...effects import direction_dependent_friction as by_direction
from ...effects import load_coulomb_friction as coulomb
from ...effects import load_inertia_error as inertia
from ...effects import load_viscous_friction as viscous
from ...effects.along import Along
from ...effects.catalogue import RIGID
from ...effects.term import Interval, Term
from ..diagnosis import BoolArray, FloatArray, Measured
from .balance import Balance
from .beside import shown, with_more
from .lower import where_inertia_holds
from .motion import Motion
from .solution import Solution

_OF_A_MOMENT = ("friction_drift", "local_jam")  # levels of a time or a place, not of the machine


def measured(
    balance: Balance, along: Along, closest: Solution, *, named: Collection[str]
) -> tuple[Measured, ...]:
    """Nominal and found values together.

    closest: fit to all rows of the set whose values they are. named: keys of the terms that are
    causes; beside them then, what every machine may have and this one shows: friction of either
    kind, a load. Where nothing comes beside them, causes are measured as they are named.
    """
    model = along.model
    terms = list(closest.free)
    keys = {one.key for one in terms}
    refined = {name for one in terms for name in one.refines} | {one.effect for one in terms}
    known = [] if _exact(along, inertia.term(along)) else [inertia.term(along)]
    friction = any(model.coulomb) and along.both_ways
    if friction and model.coulomb + model.viscous != model.coulomb[::-1] + model.viscous[::-1]:
        known.append(by_direction.term(along))
    else:
        known += [viscous.term(along)] if any(model.viscous) else []
        known += [coulomb.term(along)] if friction else []
    extra = [
        one
        for one in known
        if one.key not in keys and not refined.intersection((one.effect, *one.refines))
    ]
    beside = shown(balance, along, closest, extra) if named else []
    extra += beside
    within, fit = where_inertia_holds(balance, along.machine, [*terms, *extra])
    told = balance.intervals(closest, balance.usable)
    scale = Scale() if "gain" in keys else Scale.of(told.get("gain"), along)
    spans = within.intervals(fit, within.usable)
    spans |= {
        one.key: [scale.scaled(at) for at in spans[one.key]] for one in fit.terms if one.of_effort
    }
    if not beside:  # nothing comes beside what is named: it is measured once
        spans |= {key: told[key] for key in named if key in spans and key != "inertia"}
    sheet = {
        RIGID[one.effect].constant[not along.machine.linear]
        for one in closest.terms
        if closest.known(one)
    }
    totals = (
        _said(one, total, named, beside, sheet, along)
        for one in fit.terms
        for span in spans[one.key]
        if (total := _total(one, span, along, keys)) is not None
    )
    rows = balance.usable
    rest = with_more(balance, closest, beside).residual[rows]
    return (*totals, relative_error(balance, rest, rows))


class Scale(NamedTuple):
    """By how much all torques are more than recorded, and its 95 % half width as a share: as far as
    the gain of the effort is known."""

    factor: float = 1.0
    unsure: float = 0.0

    @classmethod
    def of(cls, gain: Sequence[Interval] | None, along: Along) -> Scale:
        """From the gain as it was found within its tolerance; exact where it has none."""
        if not gain or not along.units.own or not along.machine.gain:
            return cls()
        value, low, high = gain[0][2:]
        return cls(value / along.machine.gain, 0.5 * (high - low) / value)

    def scaled(self, span: Interval) -> Interval:
        """An effort, or what is counted by it, with its interval."""
        more = self.unsure * abs(span.value)
        low, high = (math.hypot(one - span.value, more) for one in (span.low, span.high))
        ends = (span.value, span.value - low, span.value + high)
        return Interval(span.name, span.unit, *(self.factor * one for one in ends))


def _said(
    term: Term,
    total: Measured,
    named: Collection[str],
    beside: Sequence[Term],
    sheet: Collection[str],
    along: Along,
) -> Measured:
    """With what tells it from another value of the same in one report."""
    constant = RIGID[term.effect].constant[not along.machine.linear]
    if constant and constant in sheet:  # where the data sheet has its say, it has another
        return replace(total, meaning=f"{total.meaning}, by the recording alone")
    if named and term.key not in named and term.key not in ("inertia", "gain"):
        return replace(total, meaning=f"{total.meaning}, not named")
    if beside and term.key in named:
        return replace(total, meaning=f"{total.meaning}, beside what is not named")
    return total


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


def _total(term: Term, span: Interval, along: Along, keys: set[str]) -> Measured | None:
    """A value of the whole model: what the file says with what was found."""
    model, units = along.model, along.units
    if term.key == "gain":
        meaning = "output effort per unit of the signal"
        return Measured(*span, meaning, along.machine.gain)
    if term.key == "inertia":
        if span.low <= 0.0:  # not seen, or taken by what else is found
            return None
        return Measured(*span, "all that moves", model.inertia)
    load = model.constant if "constant" not in keys else 0.0
    totals = {
        units.per_speed("viscous"): (model.viscous[0], "friction in proportion to speed"),
        units.per_speed("viscous_positive"): (model.viscous[0], "the same, forwards"),
        units.per_speed("viscous_negative"): (model.viscous[1], "the same, backwards"),
        units.level("coulomb"): (model.coulomb[0], "friction level"),
        units.level("coulomb_positive"): (
            model.coulomb[0] + load,
            "friction level forwards, constant load included",
        ),
        units.level("coulomb_negative"): (
            model.coulomb[1] - load,
            "friction level backwards, constant load included",
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


def costs(motion: Motion, along: Along, mode: float | None) -> list[str]:
    """What the drive file leaves out, and what that costs; mode: that was judged, None for all."""
    machine = along.machine
    side = "load" if machine.linear else "rotor"
    notes: list[str] = []
    general = [
        f"a rigid drive has one inertia: motor and load cannot be separated, friction is "
        f"named on the {side}; backlash, stiffness and electrical effects are not judged",
        f"compared up to {motion.bandwidth_hz:.3g} Hz (zero-phase), "
        f"{motion.rate_hz / motion.step:.3g} samples per second; faster effects are not seen",
    ]
    if motion.effort_unit not in ("N", "N m"):
        told = "" if not any(along.model.keys) else ", and found with the values of the file"
        notes.append(
            f"actuation.gain is left out{told}: effort is counted in {motion.effort_unit}, and a "
            "wrong gain cannot be seen"
        )
    if not (along.known_inertia or along.model.keys.inertia):
        key = "load.mass" if machine.linear else "load.inertia"
        notes.append(
            f"{key} is left out: it was found from the recording, so that a wrong one, or a "
            "wrong gain of the effort, cannot be seen"
        )
    if not machine.loop_known:
        notes.append(
            "no controller in the drive file: delays and limits of the loop are not judged"
        )
    if not along.both_ways:
        notes.append("the output moves one way only: Coulomb friction and a constant load are one")
    if machine.linear and machine.lead is None:
        notes.append("screw.lead is left out: what repeats over the stroke has a period in m")
    if mode is not None:
        notes.append(f"judged where the mode is {mode:g}")
    else:
        values = np.unique(motion.mode[np.isfinite(motion.mode)])
        if values.size > 1:
            listed = ", ".join(f"{one:g}" for one in values[:8].tolist())
            notes.append(
                f"the mode changes within the run ({listed}): all were judged together; "
                "--mode picks one"
            )
    return [*notes, *general]
