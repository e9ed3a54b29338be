"""The motor gives more or less torque per ampere than the nominal model has it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..drive.parameters import DriveParameters
from .effect import Effect, Quantity
from .starts import multiples


def modify(record: np.ndarray, values: Mapping[str, float], drive: DriveParameters) -> None:
    """Put the true value in the nominal one's place."""
    record["torque_constant"] = values["torque_constant_nm_per_a"]


EFFECT = Effect(
    name="torque_constant_error",
    block="motor_electrical",
    title="wrong torque constant",
    summary="The current stands in another proportion to the motion than the model says, in "
    "friction, acceleration and load alike.",
    excitation="high torque: acceleration or a known load",
    parameters=(
        Quantity(
            name="torque_constant_nm_per_a",
            unit="N m/A",
            low=1e-4,
            high=100.0,
            meaning="true torque constant",
        ),
    ),
    starts=multiples(
        "torque_constant_nm_per_a",
        lambda evidence: evidence.drive.motor.torque_constant,
        (0.6, 0.85, 1.2, 1.6),
    ),
    modify=modify,
    neutral=lambda drive: drive.motor.torque_constant,
    constant="motor.torque_constant",
)
