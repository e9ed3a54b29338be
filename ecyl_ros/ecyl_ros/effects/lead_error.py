"""The screw moves the rod further or less far per turn than the nominal model has it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..drive.parameters import DriveParameters
from .effect import Effect, Evidence, Quantity, Start
from .starts import multiples, regress

_AT = multiples("lead_m", lambda evidence: evidence.drive.transmission.lead, (0.97, 1.03))


def starts(evidence: Evidence) -> list[Start]:
    """The slope of the rod's error over the rotor angle; without a rod 3 % either way."""
    angle = evidence.rotor_angle_rad
    slope, _ = regress(evidence.rod_error_rad, angle, np.ones_like(angle))
    seen = [1.0 + float(slope)] if slope != 0.0 else []
    lead = evidence.drive.transmission.lead
    return [*({"lead_m": lead * one} for one in seen), *_AT(evidence)]


def modify(record: np.ndarray, values: Mapping[str, float], drive: DriveParameters) -> None:
    """Put the true value in the nominal one's place."""
    record["rod_per_rotor"] *= values["lead_m"] / drive.transmission.lead


EFFECT = Effect(
    name="lead_error",
    block="transmission",
    title="wrong lead",
    summary="The rod position is off in proportion to its travel; the rotor hardly notices.",
    excitation="travel, and a recorded rod position",
    parameters=(
        Quantity(
            name="lead_m",
            unit="m/rev",
            low=1e-4,
            high=0.5,
            meaning="true rod travel per screw revolution",
        ),
    ),
    starts=starts,
    modify=modify,
    neutral=lambda drive: drive.transmission.lead,
    constant="transmission.lead",
)
