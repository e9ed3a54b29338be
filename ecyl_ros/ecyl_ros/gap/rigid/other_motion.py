"""Recorded motion that does not go with the output's: of the other kind, or another scale."""

from __future__ import annotations

import numpy as np

from ...drive.rigid.machine import Machine
from ...recording.map import in_map
from ...recording.signals import Recording
from ..diagnosis import BoolArray, FloatArray

_ALIKE = 0.9  # of the squared correlation: two that tell of one motion
_OFF = 0.05  # from each other: more than filters and a late sample make

# Of a linear and of a rotary output; what a rotary one may be measured by comes first.
_LINEAR = {
    "position": ("rod_position_m",),
    "velocity": ("rod_velocity_m_per_s",),
    "reference position": ("reference_position_m",),
    "reference velocity": ("reference_velocity_m_per_s",),
}
_ROTARY = {
    "position": ("rotor_position_rad", "load_position_rad"),
    "velocity": ("rotor_velocity_rad_per_s", "load_velocity_rad_per_s"),
    "reference position": ("reference_position_rad",),
    "reference velocity": ("reference_velocity_rad_per_s",),
}


def unused_motion(recording: Recording, machine: Machine) -> list[str]:
    """A line on each signal that is not used, for the output is of the other kind."""
    own, other = (_LINEAR, _ROTARY) if machine.linear else (_ROTARY, _LINEAR)
    notes = []
    for what, names in own.items():
        if any(recording.has(name) for name in names):
            continue
        notes += [
            f"{in_map(name)} is not used: the {what} of a {machine.output} output is "
            f"{in_map(names[0])}"
            for name in other[what]
            if recording.has(name)
        ]
    return notes


def unlike_position(recorded: FloatArray, velocity: FloatArray, usable: BoolArray) -> str:
    """Says so where the recorded speed goes with the rate of the position, but as a multiple of it.

    Both float64[n], in the same band. One of the two has another unit, scale or gear behind it.
    """
    told, rate = recorded[usable], velocity[usable]
    if not np.isfinite(told).all() or not np.any(told):
        return ""
    together = float(told @ rate)
    alike = together**2 / max(float(told @ told) * float(rate @ rate), 1e-300)
    times = together / max(float(rate @ rate), 1e-300)
    if alike < _ALIKE or abs(times - 1.0) <= _OFF:
        return ""
    return (
        f"the recorded speed is {times:.3g} times the rate of the position, which is relied on: "
        "unit, scale and gear of both in the map"
    )
