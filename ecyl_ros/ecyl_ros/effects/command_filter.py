"""A first-order low-pass that the setpoint passes before the position loop."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..drive.filters import kept_share
from ..drive.parameters import DriveParameters
from .effect import Effect, Quantity
from .filter_starts import filter_starts


def modify(record: np.ndarray, values: Mapping[str, float], drive: DriveParameters) -> None:
    """Put the true filter in the nominal one's place."""
    record["setpoint_kept"] = kept_share(values["time_constant_s"], drive.controller.rate)


def _nominal(drive: DriveParameters) -> float:
    return drive.controller.setpoint_filter


EFFECT = Effect(
    name="command_filter",
    block="controller",
    title="setpoint filter",
    summary="The drive follows a smoothed setpoint: it lags the reference by the "
    "filter's time constant and rounds its corners; torque, voltage and motion agree with each "
    "other.",
    excitation="motion with corners or at several frequencies: moves, chirps, multisines",
    parameters=(
        Quantity(
            name="time_constant_s",
            unit="s",
            low=0.0,
            high=10.0,
            meaning="true time constant of the low-pass; 0: none",
        ),
    ),
    starts=filter_starts("time_constant_s", "position", _nominal),
    modify=modify,
    neutral=_nominal,
)
