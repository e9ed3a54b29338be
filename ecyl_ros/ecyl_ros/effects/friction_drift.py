"""Coulomb friction on the rotor that changes while the run lasts: warming up, drying out."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from ..drive.compiled import kernel
from ..drive.parameters import DriveParameters
from .effect import Effect, Evidence, Quantity, Start, bristle, put_bristle
from .starts import direction, regress


def starts(evidence: Evidence) -> list[Start]:
    """Level and its trend by regression."""
    sign = direction(evidence)
    level, trend = regress(evidence.torque_nm, -sign, -sign * evidence.time_s)
    level = max(float(level), 1e-4)
    return [{"coulomb_nm": level, "rate_per_s": max(float(trend) / level, -0.5)}]


def modify(record: np.ndarray, values: Mapping[str, float], drive: DriveParameters) -> None:
    """Let the contact give as the bristle says."""
    put_bristle(record, "rotor", values)


EFFECT = Effect(
    name="friction_drift",
    block="motor_mechanical",
    title="friction that drifts with time",
    summary="Coulomb friction on the rotor that falls or rises during the run: grease warming up, "
    "a bearing or brake heating.",
    excitation="the same motion early and late in the recording",
    parameters=(
        Quantity(
            name="coulomb_nm", unit="N m", low=0.0, high=1e3, meaning="level at the first sample"
        ),
        Quantity(
            name="rate_per_s",
            unit="1/s",
            low=-1.0,
            high=1.0,
            meaning="exponential rate of change of the level",
        ),
        *bristle("rotor"),
    ),
    starts=starts,
    modify=modify,
    refines=("rotor_coulomb_friction",),
)


@kernel
def rotor_friction(p, speed, torque, time):
    """Level: exponential in time."""
    if p.friction_drift_coulomb_nm == 0.0:
        return 0.0
    return p.friction_drift_coulomb_nm * math.exp(p.friction_drift_rate_per_s * time)
