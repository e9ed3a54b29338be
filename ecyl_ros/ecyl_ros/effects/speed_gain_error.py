"""The speed loop's proportional gain is another than the nominal model has it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..drive.parameters import DriveParameters
from .effect import Effect, Quantity
from .loop_gains import proportional, proportional_starts, put_proportional


def modify(record: np.ndarray, values: Mapping[str, float], drive: DriveParameters) -> None:
    """Put the true value in the nominal one's place."""
    put_proportional(record, "speed", values["kp_a_s_per_rad"], drive)


EFFECT = Effect(
    name="speed_gain_error",
    block="controller",
    title="wrong speed loop gain",
    summary="The speed loop is stiffer or softer: impacts at reversals and fast changes lead to "
    "other currents and oscillations.",
    excitation="fast changes of motion: impacts at reversals, chirps, steps",
    parameters=(
        Quantity(
            name="kp_a_s_per_rad",
            unit="A s/rad",
            low=1e-6,
            high=1e6,
            meaning="true proportional gain",
        ),
    ),
    starts=proportional_starts("kp_a_s_per_rad", "speed"),
    modify=modify,
    neutral=proportional("speed"),
    constant="controller.speed.kp",
)
