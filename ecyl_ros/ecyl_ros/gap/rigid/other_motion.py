"""Recorded motion that does not go with the output's: of the other kind, or another scale."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...arrays import BoolArray, FloatArray
from ...drive.rigid.machine import Machine
from ...recording.map import in_map
from ...recording.runs import runs_of
from ...recording.signals import Recording

_ALIKE = 0.9  # of the squared correlation: two that tell of one motion
_OFF = 0.05  # from each other: more than filters and a late sample make
_SHORTEST = 16  # samples of a stretch
_STRAIGHT = 0.1  # of the spread of a place: what goes beyond a line is next to nothing

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


class Told(NamedTuple):
    """How a recorded speed goes with the motion of a position.

    alike: squared correlation. times: as a multiple of it. Both NaN where nothing tells.
    """

    alike: float
    times: float

    @property
    def agrees(self) -> bool:
        """Whether both tell of one motion in one unit."""
        return self.alike >= _ALIKE and abs(self.times - 1.0) <= _OFF

    @property
    def note(self) -> str:
        """Says so where the two tell of different motions."""
        if not self.alike < _ALIKE:
            return ""
        return (
            "the recorded speed does not go with the position, which is used (squared "
            f"correlation of what both travel {self.alike:.2f}): jumps of the one, or another part"
        )

    @property
    def caution(self) -> str:
        """Says so where one of the two has another unit, scale or gear behind it."""
        if not self.alike >= _ALIKE or self.agrees:
            return ""
        return (
            f"the recorded speed is {self.times:.3g} times the rate of the position, which is "
            "relied on: unit, scale and gear of both in the map"
        )


def told_beside(
    recorded: FloatArray, position: FloatArray, usable: BoolArray, rate_hz: float
) -> Told:
    """How a recorded speed, float64[n], goes with a position, float64[n].

    The speed is integrated, for differences of a position are noisy; a straight line in each
    stretch of usable samples is left aside, for a speed has an offset. Over long stretches the
    integral drifts, over short ones the noise of the position shows: those count in which the two
    are most alike. Two that have nothing to do with each other are so at no length.
    """
    runs = [
        (begin, end)
        for begin, end in runs_of(usable).tolist()
        if end - begin >= _SHORTEST and np.isfinite(recorded[begin:end]).all()
    ]
    found = Told(math.nan, math.nan)
    if not runs:
        return found
    rows = np.concatenate([np.arange(begin, end) for begin, end in runs])
    sizes = np.array([end - begin for begin, end in runs])
    way, place = np.cumsum(recorded[rows]) / rate_hz, position[rows]
    longest = int(sizes.max())
    while longest >= _SHORTEST:
        told = _told(way, place, _cut(sizes, longest))
        if not found.alike >= told.alike:
            found = told
        longest //= 2
    return found


def _cut(sizes: NDArray[np.int64], longest: int) -> NDArray[np.int64]:
    """Where stretches of `sizes` in a row begin, int64, each in as few equal parts as are no longer
    than `longest`."""
    ends = np.cumsum(sizes).tolist()
    parts = [
        np.linspace(end - size, end, math.ceil(size / longest) + 1)[:-1]
        for size, end in zip(sizes.tolist(), ends, strict=True)
    ]
    return np.concatenate(parts).astype(np.int64)


def _told(way: FloatArray, place: FloatArray, begins: NDArray[np.int64]) -> Told:
    """The same of an integrated speed and a position in stretches that begin so."""
    sizes = np.diff(np.append(begins, way.size))

    def in_each(values: FloatArray) -> FloatArray:
        """Sums over each stretch."""
        return np.add.reduceat(values, begins)

    def level(values: FloatArray) -> FloatArray:
        """Less the mean of each stretch."""
        return values - np.repeat(in_each(values) / sizes, sizes)

    time = level(np.arange(way.size, dtype=np.float64))
    flat = np.stack([level(way), level(place)])
    slopes = np.stack([in_each(time * one) for one in flat]) / in_each(time**2)
    bent = flat - np.repeat(slopes, sizes, axis=1) * time
    # One way at one speed: that is the line.
    line = in_each(bent[1] ** 2) < _STRAIGHT**2 * in_each(flat[1] ** 2)
    way, place = np.where(np.repeat(line, sizes), flat, bent)
    together, power = float(way @ place), float(way @ way)
    alike = together**2 / max(power * float(place @ place), 1e-300)
    # By the way, which is the less noisy of the two.
    return Told(alike, power / together if together else math.nan)
