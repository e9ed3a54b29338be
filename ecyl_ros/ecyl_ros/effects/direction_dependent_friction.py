"""Friction of the load that differs by direction: a worn screw, a seal lip."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..drive.compiled import kernel
from ..drive.parameters import DriveParameters
from .effect import Effect, Evidence, Quantity, Start, bristle, put_bristle
from .starts import direction, regress


def starts(evidence: Evidence) -> list[Start]:
    """The unexplained torque's level and slope in each direction."""
    sign = direction(evidence)
    speed = evidence.rotor_speed_rad_s
    values = {}
    for name, way in (("positive", 1.0), ("negative", -1.0)):
        along = np.where(sign == way, evidence.torque_nm, np.nan)
        level, slope = regress(along, np.full_like(speed, -way), -speed)
        values[f"coulomb_{name}_nm"] = max(float(level), 1e-4)
        values[f"viscous_{name}_nm_s_per_rad"] = float(slope)
    return [values]


def modify(record: np.ndarray, values: Mapping[str, float], drive: DriveParameters) -> None:
    """Let the contact give as the bristle says."""
    put_bristle(record, "load", values)


EFFECT = Effect(
    name="direction_dependent_friction",
    block="load",
    title="friction that depends on direction",
    summary="The load drags more one way than the other, in level or in its rise with speed: one "
    "flank of the screw is worn, a seal lip points one way.",
    excitation="motion both ways at several speeds",
    parameters=(
        Quantity(
            name="coulomb_positive_nm", unit="N m", low=0.0, high=1e3, meaning="level, forwards"
        ),
        Quantity(
            name="coulomb_negative_nm", unit="N m", low=0.0, high=1e3, meaning="level, backwards"
        ),
        Quantity(
            name="viscous_positive_nm_s_per_rad",
            unit="N m s/rad",
            low=-10.0,
            high=100.0,
            meaning="rise with speed beyond nominal, forwards",
            default=0.0,
        ),
        Quantity(
            name="viscous_negative_nm_s_per_rad",
            unit="N m s/rad",
            low=-10.0,
            high=100.0,
            meaning="rise with speed beyond nominal, backwards",
            default=0.0,
        ),
        *bristle("load"),
    ),
    starts=starts,
    modify=modify,
    refines=("load_coulomb_friction", "load_viscous_friction"),
    sized=(
        "coulomb_positive_nm",
        "coulomb_negative_nm",
        "viscous_positive_nm_s_per_rad",
        "viscous_negative_nm_s_per_rad",
    ),
)


@kernel
def load_friction(p, speed, torque, angle, time):
    """Level by direction."""
    if speed > 0.0:
        return p.direction_dependent_friction_coulomb_positive_nm
    return p.direction_dependent_friction_coulomb_negative_nm


@kernel
def load_torque(p, time, angle, speed):
    """The rise with speed, by direction."""
    if speed > 0.0:
        return -p.direction_dependent_friction_viscous_positive_nm_s_per_rad * speed
    return -p.direction_dependent_friction_viscous_negative_nm_s_per_rad * speed
