"""A first-order low-pass between what the speed loop asks for and the current loop."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..drive.filters import kept_share
from ..drive.parameters import DriveParameters
from .effect import Effect, Quantity
from .filter_starts import filter_starts


def modify(record: np.ndarray, values: Mapping[str, float], drive: DriveParameters) -> None:
    """Put the true filter in the nominal one's place."""
    record["current_command_kept"] = kept_share(values["time_constant_s"], drive.controller.rate)


def _nominal(drive: DriveParameters) -> float:
    return drive.controller.current_command_filter


EFFECT = Effect(
    name="current_command_filter",
    block="controller",
    title="current command filter",
    summary="Current follows the speed loop's command late and smoothed: less damping, "
    "overshoot and oscillation after fast changes.",
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
