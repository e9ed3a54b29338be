"""The backlash is wider (wear) or narrower (preload) than the nominal model has it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..drive.parameters import DriveParameters
from .effect import Effect, Quantity
from .starts import multiples


def modify(record: np.ndarray, values: Mapping[str, float], drive: DriveParameters) -> None:
    """Put the true value in the nominal one's place."""
    record["half_backlash"] = 0.5 * values["backlash_rad"]


EFFECT = Effect(
    name="backlash_error",
    block="transmission",
    title="wrong backlash",
    summary="At reversals the rotor crosses more or less backlash than in the model: the flank "
    "meets later or earlier.",
    excitation="reversals",
    parameters=(
        Quantity(
            name="backlash_rad",
            unit="rad",
            low=0.0,
            high=1.0,
            meaning="true total backlash at the rotor",
        ),
    ),
    starts=multiples(
        "backlash_rad",
        lambda evidence: evidence.drive.transmission.backlash,
        (1.5, 0.5, 3.0, 0.1),
    ),
    modify=modify,
    neutral=lambda drive: drive.transmission.backlash,
    constant="transmission.backlash",
)
