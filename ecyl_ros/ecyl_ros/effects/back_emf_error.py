"""The voltage induced per speed differs from the nominal model."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..drive.parameters import DriveParameters
from .effect import Effect, Quantity
from .starts import multiples


def modify(record: np.ndarray, values: Mapping[str, float], drive: DriveParameters) -> None:
    """Put the true value in the nominal one's place."""
    record["back_emf_constant"] = values["back_emf_v_s_per_rad"]


EFFECT = Effect(
    name="back_emf_error",
    block="motor_electrical",
    title="wrong back-EMF constant",
    summary="The voltage differs in proportion to speed; the motion hardly changes.",
    excitation="high speed, and a recorded voltage",
    parameters=(
        Quantity(
            name="back_emf_v_s_per_rad",
            unit="V s/rad",
            low=1e-4,
            high=100.0,
            meaning="true back-EMF constant",
        ),
    ),
    starts=multiples(
        "back_emf_v_s_per_rad", lambda evidence: evidence.drive.motor.back_emf_constant, (0.6, 1.6)
    ),
    modify=modify,
    neutral=lambda drive: drive.motor.back_emf_constant,
    constant="motor.back_emf_constant",
)
