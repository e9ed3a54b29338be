"""The controller feeds forward more or less current for acceleration than the nominal model."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..drive.parameters import DriveParameters
from .effect import Effect, Evidence, Quantity, Start

_OF_INERTIA = (1.0, 0.5, 0.25, 1.5, 0.1, 0.03)  # of what would move rotor and load by itself
_OF_NOMINAL = (0.5, 1.6, 0.1, 3.0, 0.8, 1.25)


def modify(record: np.ndarray, values: Mapping[str, float], drive: DriveParameters) -> None:
    """Put the true value in the nominal one's place."""
    record["acceleration_feedforward"] = values["gain_a_s2_per_rad"]


def _nominal(drive: DriveParameters) -> float:
    return drive.controller.acceleration_feedforward


def starts(evidence: Evidence) -> list[Start]:
    """Multiples of the nominal value, or of both inertias over the torque constant."""
    drive, factors, scale = evidence.drive, _OF_NOMINAL, _nominal(evidence.drive)
    if scale == 0.0:
        factors = _OF_INERTIA
        scale = (drive.motor.rotor_inertia + drive.load.inertia) / drive.motor.torque_constant
    return [{"gain_a_s2_per_rad": scale * factor} for factor in factors]


EFFECT = Effect(
    name="acceleration_feedforward_error",
    block="controller",
    title="wrong acceleration feedforward",
    summary="Current comes with the reference's acceleration, before any error demands it: the "
    "drive starts and stops sooner or later than the model.",
    excitation="acceleration: quick moves, chirps, multisines",
    parameters=(
        Quantity(
            name="gain_a_s2_per_rad",
            unit="A s^2/rad",
            low=0.0,
            high=1e3,
            meaning="true current command per rad/s^2 of the reference, at the rotor",
        ),
    ),
    starts=starts,
    modify=modify,
    neutral=_nominal,
)
