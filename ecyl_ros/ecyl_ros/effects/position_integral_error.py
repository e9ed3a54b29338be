"""The position loop's integral gain is another than the nominal model has it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..drive.parameters import DriveParameters
from .effect import Effect, Quantity
from .loop_gains import integral, integral_starts


def modify(record: np.ndarray, values: Mapping[str, float], drive: DriveParameters) -> None:
    """Put the true value in the nominal one's place."""
    record["position_ki"] = values["ki_per_s2"]


EFFECT = Effect(
    name="position_integral_error",
    block="controller",
    title="wrong position loop integral gain",
    summary="The tracking error decays over a longer or shorter time than the model's, in"
    " steady motion and under load; fast motion hardly differs.",
    excitation="slow motion and long stretches at one speed, best under load",
    parameters=(
        Quantity(
            name="ki_per_s2",
            unit="1/s^2",
            low=0.0,
            high=1e9,
            meaning="true integral gain, parallel form; A/(rad s) with controller.structure "
            "position_to_current",
        ),
    ),
    starts=integral_starts("ki_per_s2", "position"),
    modify=modify,
    neutral=integral("position"),
    constant="controller.position.ki",
)
