"""Viscous friction on the rotor beyond what the nominal model has."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ..drive.parameters import DriveParameters
from . import load_viscous_friction
from .effect import Effect, Evidence, Quantity, Start
from .starts import regress


def modify(record: np.ndarray, values: Mapping[str, float], drive: DriveParameters) -> None:
    """Add to the nominal viscous friction."""
    record["rotor_viscous"] += values["viscous_nm_s_per_rad"]


def starts(evidence: Evidence) -> list[Start]:
    """The slope of the unexplained torque over speed."""
    slope = -float(regress(evidence.torque_nm, evidence.rotor_speed_rad_s)[0])
    scale = max(abs(slope), 0.1 * evidence.drive.load.viscous_friction, 1e-6)
    return [{"viscous_nm_s_per_rad": value} for value in (slope, 3.0 * scale)]


EFFECT = Effect(
    name="rotor_viscous_friction",
    block="motor_mechanical",
    title="Viscous friction on the rotor",
    summary="A torque against the rotor's motion in proportion to its speed, beyond the nominal.",
    excitation="motion at different speeds",
    separated_by="passages through the backlash separate rotor from load",
    parameters=(
        Quantity(
            name="viscous_nm_s_per_rad",
            unit="N m s/rad",
            low=-10.0,
            high=100.0,
            meaning="coefficient at the rotor, beyond nominal",
        ),
    ),
    starts=starts,
    modify=modify,
    constant="motor.viscous_friction",
    on_top=True,
)


# A drive of one inertia that turns has on its rotor what a straight one has on its load.
RIGID = replace(load_viscous_friction.RIGID, outputs=("rotary",))
