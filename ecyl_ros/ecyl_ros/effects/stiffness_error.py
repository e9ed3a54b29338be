"""The transmission is softer or stiffer than the nominal model has it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..drive.parameters import DriveParameters
from .effect import Effect, Quantity
from .starts import multiples


def modify(record: np.ndarray, values: Mapping[str, float], drive: DriveParameters) -> None:
    """Put the true value in the nominal one's place."""
    ratio = values["stiffness_nm_per_rad"] / record["stiffness"][0, 0]
    record["stiffness"] *= ratio
    record["deflection_start"] /= ratio


EFFECT = Effect(
    name="stiffness_error",
    block="transmission",
    title="wrong stiffness",
    summary="The contact torque oscillates at another frequency after a flank meets, and the twist "
    "under load differs.",
    excitation="impacts at reversals, fast reversals of torque",
    parameters=(
        Quantity(
            name="stiffness_nm_per_rad",
            unit="N m/rad",
            low=1e-3,
            high=1e8,
            meaning="true value at the rotor; further segments keep their ratio",
        ),
    ),
    starts=multiples(
        "stiffness_nm_per_rad",
        lambda evidence: evidence.drive.transmission.stiffness[0],
        (0.5, 2.0, 0.15, 0.05),
    ),
    modify=modify,
    neutral=lambda drive: drive.transmission.stiffness[0],
    constant="transmission.stiffness",
)
