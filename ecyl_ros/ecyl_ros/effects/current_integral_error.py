"""The current loop's integral gain is another than the nominal model has it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..drive.parameters import DriveParameters
from .effect import Effect, Quantity
from .loop_gains import integral, integral_starts


def modify(record: np.ndarray, values: Mapping[str, float], drive: DriveParameters) -> None:
    """Put the true value in the nominal one's place."""
    record["current_ki"] = values["ki_v_per_a_s"]


EFFECT = Effect(
    name="current_integral_error",
    block="controller",
    title="wrong current loop integral gain",
    summary="The current reaches its command sooner or later than in the model, by milliseconds.",
    excitation="sharp changes of current at speed; a recorded voltage",
    parameters=(
        Quantity(
            name="ki_v_per_a_s",
            unit="V/(A s)",
            low=0.0,
            high=1e9,
            meaning="true integral gain, parallel form",
        ),
    ),
    starts=integral_starts("ki_v_per_a_s", "current"),
    modify=modify,
    neutral=integral("current"),
    constant="controller.current.ki",
)
