"""Delay of position and speed on their way to the loop."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..drive.parameters import DriveParameters
from .delay_form import delay_form
from .effect import Effect, Quantity
from .starts import delays


def modify(record: np.ndarray, values: Mapping[str, float], drive: DriveParameters) -> None:
    """In control ticks, whole and broken ones."""
    record["measurement_delay"] += values["delay_s"] * drive.controller.rate


EFFECT = Effect(
    name="measurement_delay",
    block="timing",
    title="measurement delay",
    summary="The loop acts on delayed positions and speeds: less damping, overshoot, ringing at "
    "fast changes.",
    excitation="fast changes of motion: impacts at reversals, chirps, steps",
    parameters=(
        Quantity(
            name="delay_s",
            unit="s",
            low=0.0,
            high=0.05,
            meaning="age of position and speed when the loop uses them",
        ),
    ),
    starts=delays("delay_s"),
    form=delay_form,
    modify=modify,
)
