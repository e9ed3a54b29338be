"""A current limit below the one the nominal model has."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..drive.parameters import DriveParameters
from .effect import Effect, Evidence, Quantity, Start
from .starts import limits


def modify(record: np.ndarray, values: Mapping[str, float], drive: DriveParameters) -> None:
    """The lower of the two limits acts."""
    record["current_limit"] = min(float(record["current_limit"][0]), values["current_a"])


def starts(evidence: Evidence) -> list[Start]:
    """About the largest value recorded."""
    return limits("current_a", evidence.current_a)


EFFECT = Effect(
    name="current_limit",
    block="controller",
    title="current limit",
    summary="The controller's current stops at a value below the nominal limit: flat tops, and the "
    "drive falls behind while it lasts.",
    excitation="motion that needs more current than the limit",
    parameters=(Quantity(name="current_a", unit="A", low=1e-3, high=1e5, meaning="true limit"),),
    starts=starts,
    modify=modify,
    sized=(),
)
