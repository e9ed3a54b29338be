"""Inverter dead time: voltage lost against the sign of the current."""

from __future__ import annotations

import math

import numpy as np

from ..drive.compiled import kernel
from .effect import Effect, Evidence, Quantity, Start


def starts(evidence: Evidence) -> list[Start]:
    """Fractions of the voltage that drives the current at hand."""
    swing = float(np.nanstd(evidence.current_a)) * evidence.drive.motor.resistance
    return [{"voltage_v": max(swing, 1e-3) * factor} for factor in (1.0, 4.0)]


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
    ),
    starts=starts,
)


@kernel
def inverter_voltage(p, current, voltage):
    """Against the sign of the current."""
    if p.inverter_dead_time_voltage_v == 0.0:
        return 0.0
    return -p.inverter_dead_time_voltage_v * math.tanh(current / p.inverter_dead_time_transition_a)
