"""Torque ripple: a torque constant that varies over the rotor angle."""

from __future__ import annotations

import math

from ..drive.compiled import kernel
from .effect import Effect, Evidence, Quantity, Start, phase
from .starts import angular_orders, strongest


def starts(evidence: Evidence) -> list[Start]:
    """The strongest lines of the unexplained torque, as shares of the motor's torque."""
    angle = evidence.rotor_angle_rad
    motor_torque = evidence.drive.motor.torque_constant * evidence.current_a
    lines = strongest(evidence.torque_nm, angle, angular_orders(angle, 96.0), 4, motor_torque)
    return [
        {"fraction": min(size, 1.0), "periods_per_rev": order, "phase_rad": shift}
        for order, size, shift in lines
    ]


EFFECT = Effect(
    name="torque_ripple",
    block="motor_mechanical",
    title="torque ripple",
    summary="The motor's torque per ampere varies with the rotor angle: ripple that grows with "
    "the torque and vanishes without it.",
    excitation="high torque while the rotor turns over several periods",
    parameters=(
        Quantity(
            name="fraction", unit="1", low=0.0, high=1.0, meaning="peak share of the motor's torque"
        ),
        Quantity(
            name="periods_per_rev", unit="1", low=0.9, high=1e3, meaning="periods per rotor turn"
        ),
        phase("of the sine at rotor angle zero"),
    ),
    starts=starts,
)


@kernel
def rotor_torque(p, angle, speed, current):
    """The motor's torque times a sine of the rotor angle."""
    if p.torque_ripple_fraction == 0.0:
        return 0.0
    share = p.torque_ripple_fraction * math.sin(
        p.torque_ripple_periods_per_rev * angle + p.torque_ripple_phase_rad
    )
    return p.torque_constant * current * share
