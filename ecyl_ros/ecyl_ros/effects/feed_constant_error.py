"""The controller turns its reference into a rotor angle by another feed constant than the model.

Drives call it feed constant, electronic gear or counts per unit: travel per turn as it was set up.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..drive.parameters import DriveParameters
from .effect import Effect, Evidence, Quantity, Start
from .starts import regress

_EITHER_WAY = (-0.01, 0.01)


def modify(record: np.ndarray, values: Mapping[str, float], drive: DriveParameters) -> None:
    """Put the true feed constant in the nominal one's place."""
    nominal = drive.controller.feed_scale
    record["believed_rotor_per_rod"] *= nominal / (nominal + values["error"])


def starts(evidence: Evidence) -> list[Start]:
    """By how much the rotor goes faster than the model's; and 1 % either way.

    None where the position loop closes on the rod: it follows, whatever the rotor does.
    """
    if evidence.drive.controller.feedback != "rotor":
        return []
    nominal, error = evidence.drive.controller.feed_scale, evidence.rotor_speed_error_rad_s
    slope = float(regress(error, evidence.rotor_speed_rad_s - error)[0])
    seen = [1.0 / (1.0 + slope) - 1.0] if slope != 0.0 and slope > -0.5 else []
    return [{"error": nominal * one} for one in (*seen, *_EITHER_WAY)]


EFFECT = Effect(
    name="feed_constant_error",
    block="controller",
    title="wrong feed constant",
    summary="The rotor goes further or less far than the reference commands, in proportion to the "
    "travel; rod and rotor agree with each other.",
    excitation="travel, and a position loop that closes on the rotor",
    parameters=(
        Quantity(
            name="error",
            unit="1",
            low=-0.9,
            high=1e2,
            meaning="by which the controller's feed constant is larger, as a share of the lead",
        ),
    ),
    starts=starts,
    modify=modify,
    constant="controller.feed_scale",
)
