"""The winding (and cable) resists more or less than the nominal model has it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..drive.parameters import DriveParameters
from .effect import Effect, Quantity
from .starts import multiples


def modify(record: np.ndarray, values: Mapping[str, float], drive: DriveParameters) -> None:
    """Put the true value in the nominal one's place."""
    record["resistance"] = values["resistance_ohm"]


EFFECT = Effect(
    name="resistance_error",
    block="motor_electrical",
    title="wrong resistance",
    summary="The voltage differs in proportion to the current; the motion hardly changes.",
    excitation="high current, and a recorded voltage",
    parameters=(
        Quantity(
            name="resistance_ohm", unit="ohm", low=1e-4, high=1e3, meaning="true stator resistance"
        ),
    ),
    starts=multiples(
        "resistance_ohm", lambda evidence: evidence.drive.motor.resistance, (0.5, 2.0)
    ),
    modify=modify,
    neutral=lambda drive: drive.motor.resistance,
    constant="motor.resistance",
)
