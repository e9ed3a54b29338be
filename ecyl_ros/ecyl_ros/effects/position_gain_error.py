"""The position loop's proportional gain is another than the nominal model has it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..drive.parameters import DriveParameters
from .effect import Effect, Quantity
from .loop_gains import proportional, proportional_starts, put_proportional


def modify(record: np.ndarray, values: Mapping[str, float], drive: DriveParameters) -> None:
    """Put the true value in the nominal one's place."""
    put_proportional(record, "position", values["kp_per_s"], drive)


EFFECT = Effect(
    name="position_gain_error",
    block="controller",
    title="wrong position loop gain",
    summary="The drive lags its reference by more or less than the model, in proportion "
    "to the speed; torque, voltage and motion agree with each other.",
    excitation="motion at speed, best at several frequencies",
    parameters=(
        Quantity(
            name="kp_per_s",
            unit="1/s",
            low=1e-6,
            high=1e6,
            meaning="true proportional gain; A/rad with controller.structure position_to_current",
        ),
    ),
    starts=proportional_starts("kp_per_s", "position"),
    modify=modify,
    neutral=proportional("position"),
    constant="controller.position.kp",
)
