"""The current loop's proportional gain is another than the nominal model has it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..drive.parameters import DriveParameters
from .effect import Effect, Quantity
from .loop_gains import proportional, proportional_starts, put_proportional


def modify(record: np.ndarray, values: Mapping[str, float], drive: DriveParameters) -> None:
    """Put the true value in the nominal one's place."""
    put_proportional(record, "current", values["kp_v_per_a"], drive)


EFFECT = Effect(
    name="current_gain_error",
    block="controller",
    title="wrong current loop gain",
    summary="The voltage responds to fast changes of the current command more or less "
    "strongly; the motion hardly differs.",
    excitation="sharp changes of current: impacts, jerk, chirps; and a recorded voltage",
    parameters=(
        Quantity(
            name="kp_v_per_a",
            unit="V/A",
            low=1e-6,
            high=1e6,
            meaning="true proportional gain",
        ),
    ),
    starts=proportional_starts("kp_v_per_a", "current"),
    modify=modify,
    neutral=proportional("current"),
    constant="controller.current.kp",
)
