"""Inverter dead time: voltage lost against the sign of the current."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from ..drive.compiled import kernel
from .effect import Effect, Evidence, Quantity, Start

_LOST = math.tanh(1.0)  # share that is lost at the transition
_SOMEWHAT = 0.1  # straightness that a fit begins with: it moves in proportion


def starts(evidence: Evidence) -> list[Start]:
    """Fractions of the voltage that drives the current at hand."""
    current = evidence.current_a[np.isfinite(evidence.current_a)]
    swing = float(np.std(current)) * evidence.drive.motor.resistance if current.size else 0.0
    return [
        {"voltage_v": max(swing, 1e-3) * factor, "straightness": _SOMEWHAT} for factor in (1.0, 4.0)
    ]


def current_span(values: Mapping[str, float]) -> float:
    """The transition: within it the loss acts like a large resistance."""
    return values["transition_a"] if values["voltage_v"] > 0.0 else 0.0


EFFECT = Effect(
    name="inverter_dead_time",
    block="motor_electrical",
    title="inverter dead time",
    summary="The inverter gives less voltage than commanded, by a constant against the sign of the "
    "current: the current flattens at its zero crossings, the commanded voltage steps there.",
    excitation="currents that cross zero, and a recorded voltage",
    parameters=(
        Quantity(name="voltage_v", unit="V", low=0.0, high=1e3, meaning="voltage lost"),
        # Ripple and the switches' capacitance round the step off. A wider one is a resistance.
        Quantity(
            name="transition_a",
            unit="A",
            low=1e-4,
            high=0.3,
            meaning="current at which 76 % of the voltage is lost",
            default=0.05,
            nuisance=True,
        ),
        # Capacitance alone makes a straight line with corners, ripple rounds these off.
        Quantity(
            name="straightness",
            unit="1",
            low=0.0,
            high=1.0,
            meaning="0: lost along a tanh, 1: along a straight line with corners",
            default=0.0,
            nuisance=True,
        ),
    ),
    starts=starts,
    current_span=current_span,
)


@kernel
def _tanh(x):
    """Half the time of `math.tanh`, and no more than a rounding off it."""
    return 1.0 - 2.0 / (math.exp(2.0 * x) + 1.0)


@kernel
def inverter_resistance(p, current, voltage):
    """The slope of the loss."""
    if p.inverter_dead_time_voltage_v == 0.0:
        return 0.0
    share = current / p.inverter_dead_time_transition_a
    straight = p.inverter_dead_time_straightness
    curved = _tanh(share)
    slope = (1.0 - straight) * (1.0 - curved * curved)
    if _LOST * abs(share) < 1.0:
        slope += straight * _LOST
    return slope * p.inverter_dead_time_voltage_v / p.inverter_dead_time_transition_a


@kernel
def inverter_voltage(p, current, voltage):
    """Against the sign of the current."""
    if p.inverter_dead_time_voltage_v == 0.0:
        return 0.0
    share = current / p.inverter_dead_time_transition_a
    straight = p.inverter_dead_time_straightness
    lost = (1.0 - straight) * _tanh(share)
    if straight > 0.0:
        lost += straight * min(max(_LOST * share, -1.0), 1.0)
    return -p.inverter_dead_time_voltage_v * lost
