"""Offset of the q-current sensor; the current loop regulates the wrong value."""

from __future__ import annotations

import numpy as np

from ..drive.compiled import kernel
from .effect import Effect, Evidence, Quantity, Start
from .starts import direction, regress


def starts(evidence: Evidence) -> list[Start]:
    """The current that the mean of the unexplained torque stands for."""
    both = regress(evidence.torque_nm, np.ones_like(evidence.time_s), direction(evidence))
    offset = -float(both[0]) / evidence.drive.motor.torque_constant
    offset = offset if abs(offset) > 1e-6 else 1e-2
    return [{"offset_a": offset * factor} for factor in (1.0, -1.0)]


EFFECT = Effect(
    name="current_sensor_offset",
    block="sensor",
    title="current sensor offset",
    summary="The recorded current is offset from zero while the motion shows no force: the loop "
    "regulates a wrong current.",
    excitation="rest and passages through the backlash, which distinguish it from a constant load",
    parameters=(
        Quantity(name="offset_a", unit="A", low=-1e3, high=1e3, meaning="added to the reading"),
    ),
    starts=starts,
    rarity=2,
)


@kernel
def current_error(p, current):
    """Constant."""
    return p.current_sensor_offset_offset_a
