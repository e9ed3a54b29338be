"""Friction on the rotor that falls from a static to a Coulomb level with speed."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from ..drive.compiled import kernel
from ..drive.parameters import DriveParameters
from .effect import Effect, Evidence, Quantity, Start, bristle, put_bristle
from .starts import direction, regress


def starts(evidence: Evidence) -> list[Start]:
    """Coulomb level by regression, static level above it, over a range of Stribeck speeds."""
    level = -float(
        regress(evidence.torque_nm, direction(evidence), np.ones_like(evidence.time_s))[0]
    )
    level = max(level, 1e-4)
    top = float(np.nanmax(np.abs(evidence.rotor_speed_rad_s), initial=1e-3))
    return [
        {"coulomb_nm": level, "static_nm": 1.6 * level, "stribeck_rad_s": top * share}
        for share in (0.01, 0.05, 0.2)
    ]


def modify(record: np.ndarray, values: Mapping[str, float], drive: DriveParameters) -> None:
    """Let the contact give as the bristle says."""
    put_bristle(record, "rotor", values)


EFFECT = Effect(
    name="stribeck_friction",
    block="motor_mechanical",
    title="Stribeck friction on the rotor",
    summary="Friction that is higher at rest than in motion: slow motion jerks, breaking away "
    "takes more torque than going on.",
    excitation="slow motion and reversals beside fast motion",
    parameters=(
        Quantity(name="coulomb_nm", unit="N m", low=0.0, high=1e3, meaning="level at speed"),
        Quantity(name="static_nm", unit="N m", low=0.0, high=1e3, meaning="level at rest"),
        Quantity(
            name="stribeck_rad_s",
            unit="rad/s",
            low=1e-3,
            high=1e3,
            meaning="rotor speed at which the surplus has fallen to 1/e",
        ),
        *bristle("rotor"),
    ),
    starts=starts,
    modify=modify,
    refines=("rotor_coulomb_friction",),
    sized=("coulomb_nm", "static_nm"),
)


@kernel
def rotor_friction(p, speed, torque, time):
    """Level: Coulomb plus the surplus, falling as a Gaussian of speed."""
    surplus = p.stribeck_friction_static_nm - p.stribeck_friction_coulomb_nm
    if surplus <= 0.0:  # resisting less at rest than in motion is another effect
        return p.stribeck_friction_coulomb_nm
    ratio = speed / p.stribeck_friction_stribeck_rad_s
    return p.stribeck_friction_coulomb_nm + surplus * math.exp(-ratio * ratio)
