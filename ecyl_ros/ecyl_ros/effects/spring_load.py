"""A spring on the rod: a hose, a seal stack, an elastic counterpart."""

from __future__ import annotations

import numpy as np

from ..drive.compiled import kernel
from .effect import Effect, Evidence, Quantity, Start
from .starts import regress


def starts(evidence: Evidence) -> list[Start]:
    """The slope of the unexplained torque over the rod's position."""
    ratio = evidence.drive.transmission.rod_per_rotor
    slope, _ = regress(evidence.torque_nm, evidence.rotor_angle_rad, np.ones_like(evidence.time_s))
    stiffness = max(-float(slope), 1e-9) / ratio**2
    return [{"stiffness_n_per_m": stiffness * factor} for factor in (1.0, 0.3, 2.5)]


EFFECT = Effect(
    name="spring_load",
    block="load",
    title="spring load",
    summary="A force towards position zero in proportion to the distance from it.",
    excitation="travel, and rest at different positions",
    parameters=(
        Quantity(name="stiffness_n_per_m", unit="N/m", low=0.0, high=1e10, meaning="at the rod"),
    ),
    starts=starts,
)


@kernel
def load_torque(p, time, angle, speed):
    """Towards position zero."""
    return -p.spring_load_stiffness_n_per_m * p.rod_per_rotor * p.rod_per_rotor * angle
