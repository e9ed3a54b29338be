"""A place on the stroke where the rod drags: dirt, a dent, a bent rod."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from ..drive.compiled import kernel
from ..drive.parameters import DriveParameters
from .effect import Effect, Evidence, Quantity, Start, bristle, put_bristle
from .starts import direction


def starts(evidence: Evidence) -> list[Start]:
    """Where along the stroke the unexplained torque drags most, over several widths."""
    ratio = evidence.drive.transmission.rod_per_rotor
    position = evidence.rotor_angle_rad * ratio
    drag = -evidence.torque_nm * direction(evidence)
    rows = np.isfinite(drag) & np.isfinite(position)
    if rows.sum() < 200:
        return []
    low, high = float(position[rows].min()), float(position[rows].max())
    edges = np.linspace(low, high, 41)
    middle = 0.5 * (edges[1:] + edges[:-1])
    bins = np.clip(np.digitize(position[rows], edges) - 1, 0, len(middle) - 1)
    count = np.bincount(bins, minlength=len(middle))
    profile = np.bincount(bins, weights=drag[rows], minlength=len(middle)) / np.maximum(count, 1)
    profile[count < 5] = 0.0
    found: list[Start] = []
    for width in (0.03, 0.1, 0.25):
        window = np.exp(-0.5 * ((middle[:, None] - middle) / (width * (high - low))) ** 2)
        smooth = window @ profile / window.sum(axis=1)
        best = int(np.argmax(smooth))
        found.append(
            {
                "coulomb_nm": max(float(profile[best]), 1e-3),
                "position_m": float(middle[best]),
                "width_m": width * (high - low),
            }
        )
    return found


def modify(record: np.ndarray, values: Mapping[str, float], drive: DriveParameters) -> None:
    """Let the contact give as the bristle says."""
    put_bristle(record, "load", values)


EFFECT = Effect(
    name="local_jam",
    block="load",
    title="local jam",
    summary="The load drags at one place of the stroke and nowhere else, in both directions.",
    excitation="passes over the place in both directions and travel well beyond it",
    parameters=(
        Quantity(name="coulomb_nm", unit="N m", low=0.0, high=1e3, meaning="peak, at the rotor"),
        Quantity(name="position_m", unit="m", low=-10.0, high=10.0, meaning="of its middle"),
        Quantity(
            name="width_m", unit="m", low=1e-6, high=10.0, meaning="standard deviation of the bell"
        ),
        *bristle("load"),
    ),
    starts=starts,
    modify=modify,
    refines=("load_coulomb_friction", "rotor_coulomb_friction"),
)


@kernel
def load_friction(p, speed, torque, angle, time):
    """Level: a bell over the rod's position."""
    if p.local_jam_coulomb_nm == 0.0:
        return 0.0
    distance = (angle * p.rod_per_rotor - p.local_jam_position_m) / p.local_jam_width_m
    return p.local_jam_coulomb_nm * math.exp(-0.5 * distance * distance)
