"""The controller feeds forward another share of the reference velocity than the nominal model."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..drive.parameters import DriveParameters
from .effect import Effect, Evidence, Quantity, Start

_SHARES = (1.0, 0.5, 0.8, 0.25, 0.02, 1.2)  # most drives have all of it or none
_APART = 0.1


def modify(record: np.ndarray, values: Mapping[str, float], drive: DriveParameters) -> None:
    """Put the true share in the nominal one's place."""
    record["velocity_feedforward"] = values["share"]


def _nominal(drive: DriveParameters) -> float:
    return drive.controller.velocity_feedforward


def starts(evidence: Evidence) -> list[Start]:
    """Shares that are in use, but for the nominal one; none without a speed loop to feed."""
    drive = evidence.drive
    if drive.controller.structure != "cascade":
        return []
    return [{"share": one} for one in _SHARES if abs(one - _nominal(drive)) > _APART]


EFFECT = Effect(
    name="velocity_feedforward_error",
    block="controller",
    title="wrong velocity feedforward",
    summary="The drive lags its reference by more or less than the model, in proportion to the "
    "speed, and follows changes of speed sooner or later.",
    excitation="motion at speed, best at several frequencies",
    parameters=(
        Quantity(
            name="share",
            unit="1",
            low=0.0,
            high=2.0,
            meaning="true share of the reference velocity added to the speed command",
        ),
    ),
    starts=starts,
    modify=modify,
    neutral=_nominal,
)
