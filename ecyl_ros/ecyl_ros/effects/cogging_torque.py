"""Cogging: torque of the magnets against the slots, over the rotor angle."""

from __future__ import annotations

import math

from ..drive.compiled import kernel
from .effect import Effect, Evidence, Quantity, Start, phase
from .starts import angular_orders, strongest


def starts(evidence: Evidence) -> list[Start]:
    """The strongest lines of the unexplained torque over the rotor angle."""
    angle = evidence.rotor_angle_rad
    lines = strongest(
        evidence.torque_nm, angle, angular_orders(angle, 96.0), 4, evidence.time_s * 0.0 + 1.0
    )
    return [
        {"amplitude_nm": size, "periods_per_rev": order, "phase_rad": shift}
        for order, size, shift in lines
    ]


EFFECT = Effect(
    name="cogging_torque",
    block="motor_mechanical",
    title="cogging torque",
    summary="A torque that goes round with the rotor angle whatever the current: ripple at a "
    "frequency in proportion to speed, largest in effect at low speed.",
    excitation="slow motion over several periods of the slots",
    parameters=(
        Quantity(name="amplitude_nm", unit="N m", low=0.0, high=1e3, meaning="peak torque"),
        Quantity(
            name="periods_per_rev", unit="1", low=0.9, high=1e3, meaning="periods per rotor turn"
        ),
        phase("of the sine at rotor angle zero"),
    ),
    starts=starts,
)


@kernel
def rotor_torque(p, angle, speed, current):
    """A sine of the rotor angle."""
    if p.cogging_torque_amplitude_nm == 0.0:
        return 0.0
    return p.cogging_torque_amplitude_nm * math.sin(
        p.cogging_torque_periods_per_rev * angle + p.cogging_torque_phase_rad
    )
