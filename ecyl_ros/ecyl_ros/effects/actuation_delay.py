"""Delay of the voltage on its way to the inverter."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ..arrays import FloatArray
from ..drive.parameters import DriveParameters
from .along import Along
from .delay_form import delay_form
from .effect import Effect, Quantity
from .rigid_form import RigidForm, Stem, added
from .starts import delays
from .term import Fitted, Term, plain


def modify(record: np.ndarray, values: Mapping[str, float], drive: DriveParameters) -> None:
    """In control ticks, whole and broken ones."""
    record["actuation_delay"] += values["delay_s"] * drive.controller.rate


EFFECT = Effect(
    name="actuation_delay",
    block="timing",
    title="actuation delay",
    summary="The inverter applies each voltage with a delay beyond the nominal one: the current "
    "loop rings.",
    excitation="fast changes of motion: impacts at reversals, chirps, steps",
    parameters=(
        Quantity(
            name="delay_s",
            unit="s",
            low=0.0,
            high=0.05,
            meaning="from command to inverter, beyond nominal",
        ),
    ),
    starts=delays("delay_s"),
    form=delay_form,
    modify=modify,
)


# Less between effort and motion than so many sampling periods is that of sampling and holding: up
# to two from one signal to another in a log, and half of one for which a command is held.
LATE = 2.5
_AGREES = 0.25  # of a delay by the course of the effort that it may be off by its size
LAG = "lag"
SAMPLING = "within the lag of sampling and holding"


def term(along: Along, explained: FloatArray, delay_s: float) -> Term:
    """Effort ahead of a rigid drive's motion: a late actuator.

    explained: effort explained so far, float64[n]. delay_s: about what it will come to.
    """
    rate_hz = along.motion.rate_hz
    delay_s = max(delay_s, 1.0 / rate_hz)
    ahead = np.interp(along.motion.time_s + delay_s, along.motion.time_s, explained)
    column = (ahead - explained) / delay_s
    return Term(
        effect="actuation_delay",
        key="delay",
        columns=column[None],
        parameters=lambda c: (("delay_s", "s", float(c[0])),),
        values=lambda c: {"delay": float(c[0])},
        low=(0.0,),
        alternatives=("measurement_delay",),
        least=LATE / rate_hz,
        # The log's own lag is in it; where the loop is worked out from the motion, holding alone.
        unsure=(1.0 if along.machine.actuation == "loop" else LATE) / rate_hz,
        sought=delay_s,
        again=lambda left, values: term(
            along, left.explained - float(values[0]) * column, max(float(values[0]), 0.0)
        ),
        follows=True,
        of_effort=False,
    )


def _void(fitted: Fitted) -> str:
    """Another time suits the effort's size than its course: then it is no delay."""
    span, sought = fitted.spans[0], fitted.term.sought
    freed = span.low + span.high - span.value  # of what noise makes of it
    if min(freed, span.value) <= fitted.term.least:
        return SAMPLING
    by_fit = math.sqrt(max((span.high - span.value) ** 2 - fitted.term.unsure**2, 0.0))
    reach = max(by_fit, _AGREES * sought)
    if abs(span.value - sought) > reach:
        return f"by its course it would be {sought:.3g} s, by its size {span.value:.3g} s"
    return plain(fitted)


def lag(along: Along, known_s: float) -> Term:
    """What is left of the lag of sampling, either way, to first order.

    known_s: what the recorded effort is ahead of the motion by, as far as it is taken out; the
    slope of the effort is that of the same instants, else its noise would look like a lag.
    """
    motion = along.motion
    slope = motion.derived(motion.effort, 1, known_s)
    return Term(
        effect="actuation_delay",
        key=LAG,
        columns=slope[None],
        parameters=lambda c: (("lag_s", "s", float(c[0])),),
        values=lambda c: {"delay": float(c[0])},
        low=(-math.inf,),
        of_effort=False,
    )


RIGID = RigidForm(
    stems=(Stem("delay", "time", -1.0, 1.0, "from effort to motion"),),
    term=term,
    tried=lambda along, left: [(left.explained, left.delay())],
    modify=lambda model, values: replace(model, delay_s=model.delay_s + values["delay"]),
    void=_void,
    merged=added,
)
