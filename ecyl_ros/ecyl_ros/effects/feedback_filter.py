"""A first-order low-pass on the speed that the loop sees; the recorded speed is before it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..drive.filters import kept_share
from ..drive.parameters import DriveParameters
from .effect import Effect, Quantity
from .filter_starts import filter_starts


def modify(record: np.ndarray, values: Mapping[str, float], drive: DriveParameters) -> None:
    """Put the true filter in the nominal one's place."""
    record["speed_kept"] = kept_share(values["time_constant_s"], drive.controller.rate)


def _nominal(drive: DriveParameters) -> float:
    return drive.controller.speed_filter


EFFECT = Effect(
    name="feedback_filter",
    block="controller",
    title="speed feedback filter",
    summary="The loop acts on a low-passed speed: less damping, overshoot and oscillation after "
    "fast changes, while the position feedback is prompt.",
    excitation="fast changes of motion: impacts at reversals, chirps, steps",
    parameters=(
        Quantity(
            name="time_constant_s",
            unit="s",
            low=0.0,
            high=1.0,
            meaning="true time constant of the low-pass; 0: none",
        ),
    ),
    starts=filter_starts("time_constant_s", "speed", _nominal),
    modify=modify,
    neutral=_nominal,
)
