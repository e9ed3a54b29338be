"""The speed loop's integral gain is another than the nominal model has it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..drive.parameters import DriveParameters
from .effect import Effect, Quantity
from .loop_gains import integral, integral_starts


def modify(record: np.ndarray, values: Mapping[str, float], drive: DriveParameters) -> None:
    """Put the true value in the nominal one's place."""
    record["speed_ki"] = values["ki_a_per_rad"]


EFFECT = Effect(
    name="speed_integral_error",
    block="controller",
    title="wrong speed loop integral gain",
    summary="The speed loop corrects errors from friction and load faster or more slowly than in "
    "the model.",
    excitation="reversals, loads and changes of speed",
    parameters=(
        Quantity(
            name="ki_a_per_rad",
            unit="A/rad",
            low=0.0,
            high=1e9,
            meaning="true integral gain, parallel form",
        ),
    ),
    starts=integral_starts("ki_a_per_rad", "speed"),
    modify=modify,
    neutral=integral("speed"),
    constant="controller.speed.ki",
)
