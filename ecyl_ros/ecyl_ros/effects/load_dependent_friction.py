"""Friction of the load in proportion to the torque it transmits: the screw under load."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..drive.compiled import kernel
from ..drive.parameters import DriveParameters
from .effect import Effect, Evidence, Quantity, Start, bristle, put_bristle
from .starts import direction, regress


def starts(evidence: Evidence) -> list[Start]:
    """Regression of the unexplained torque on the motor's, against the motion."""
    torque = np.abs(evidence.drive.motor.torque_constant * evidence.current_a)
    share = -float(regress(evidence.torque_nm, torque * direction(evidence))[0])
    return [{"coefficient": min(max(share, 1e-3) * factor, 0.9)} for factor in (1.0, 2.0)]


def modify(record: np.ndarray, values: Mapping[str, float], drive: DriveParameters) -> None:
    """Let the contact give as the bristle says."""
    put_bristle(record, "load", values)


EFFECT = Effect(
    name="load_dependent_friction",
    block="load",
    title="load-dependent friction",
    summary="Friction that grows with the torque through the screw: efficiency below one.",
    excitation="high and low torque at similar speeds",
    parameters=(
        Quantity(
            name="coefficient",
            unit="1",
            low=0.0,
            high=1.0,
            meaning="friction level over the size of the transmitted torque",
        ),
        *bristle("load"),
    ),
    starts=starts,
    modify=modify,
)


@kernel
def load_friction(p, speed, torque, angle, time):
    """Level: a share of what is transmitted."""
    return p.load_dependent_friction_coefficient * abs(torque)
