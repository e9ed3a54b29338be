"""A current limit below the one the nominal model has."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..drive.parameters import DriveParameters
from .effect import Effect, Evidence, Quantity, Start


def modify(record: np.ndarray, values: Mapping[str, float], drive: DriveParameters) -> None:
    """The lower of the two limits acts."""
    record["current_limit"] = min(float(record["current_limit"][0]), values["current_a"])


def starts(evidence: Evidence) -> list[Start]:
    """A limit that acts shows itself as the largest value recorded."""
    largest = float(np.nanmax(np.abs(evidence.current_a), initial=0.0))
    return [{"current_a": largest * factor} for factor in (1.0, 0.97, 0.9) if largest > 0.0]


EFFECT = Effect(
    name="current_limit",
    block="controller",
    title="current limit",
    summary="The controller's current stops at a value below the nominal limit: flat tops, and the "
    "drive falls behind while it lasts.",
    excitation="motion that asks for more current than the limit",
    parameters=(
        Quantity(
            name="current_a", unit="A", low=1e-3, high=1e5, meaning="limit that acts in truth"
        ),
    ),
    starts=starts,
    modify=modify,
    sized=(),
)
