"""Several recordings of one machine as one motion: each filtered by itself, in its own noise.

The samples of all stand behind one another on one grid, with a pause between two recordings that is
longer than a stretch, so that none is of two. What is compared of each is counted in its own noise:
efforts and columns are divided by how noisy the recording is beside all of them.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline

from ...arrays import FloatArray
from ...drive.rigid.machine import Machine
from ...errors import InputError
from ...recording.signals import Recording
from ..split import STRETCH_S
from .balance import MOST_STRETCHES
from .band import low_passed
from .motion import Motion, motion_of
from .noise import acceleration_noise, effort_noise, weighed

_HIGHEST = 0.4  # of the rate: a wider band than that is none of a slower recording
_FINEST = 1e-3  # of the effort, that no sensor tells better than
_SAME_RATE = 0.01  # by which rates may differ and count as one


@dataclass(frozen=True, eq=False, kw_only=True)
class Joined(Motion):
    """See the module and `Motion`.

    Attributes:
        spans: samples of each recording. noise: float64[recordings], its noise over that of all.
    """

    spans: tuple[slice, ...]
    noise: FloatArray

    @property
    def parts(self) -> tuple[slice, ...]:
        """See `Course`."""
        return self.spans

    @property
    def own_s(self) -> FloatArray:
        """See `Course`."""
        return np.concatenate([self.time_s[one] - self.time_s[one.start] for one in self.spans])

    @property
    def counted(self) -> FloatArray:
        """float64[m], noise of the recording that a compared sample is of, over that of all."""
        return self.noise[self.recording]

    def filtered(self, columns: FloatArray) -> FloatArray:
        """See `Motion`."""
        return self.in_band(columns) / self.counted

    def shifted(self, values: FloatArray, later_s: FloatArray) -> FloatArray:
        """See `Motion`."""
        of = self.recording
        found = np.empty((np.size(later_s), of.size))
        for number, one in enumerate(self.spans):
            own, rows = self._parallel(values[one]), self.rows[of == number] - one.start
            at = rows - np.asarray(later_s)[:, None] * self.rate_hz
            course = CubicSpline(np.arange(own.size), own)
            found[:, of == number] = course(np.clip(at, 0.0, own.size - 1.0))
        return found / self.counted

    def smoothed(self, values: FloatArray) -> FloatArray:
        """See `Motion`."""
        return np.concatenate([low_passed(self._smoothing, values[one]) for one in self.spans])


def motions_of(
    recordings: Sequence[Recording],
    machine: Machine,
    sources: Sequence[str],
    mode: float | None = None,
) -> tuple[Motion, ...]:
    """The motion in each recording, at the rate of the slowest, in the widest band of all.

    Raises:
        InputError: see `motion_of`; efforts that are not of one kind.
    """
    every = list(zip(recordings, sources, strict=True))
    whole = sum(one.duration_s for one in recordings)
    times = [whole / max(one.duration_s, 1e-9) for one in recordings]
    found = [
        motion_of(one, machine, source, mode, times=long)
        for (one, source), long in zip(every, times, strict=True)
    ]
    slowest = min(one.rate_hz for one in found)
    rates = [slowest if one.rate_hz > (1.0 + _SAME_RATE) * slowest else None for one in found]
    # What noise of the position does in a wider band than it would have is weighed down.
    band = max(min(one.bandwidth_hz, _HIGHEST * slowest) for one in found)
    in_one = dataclasses.replace(machine, bandwidth_hz=band)
    by_speed = all(one.by_speed for one in found)
    made = []
    for (one, source), rate, before in zip(every, rates, found, strict=True):
        if before.by_speed and not by_speed:  # in one way or the other, all the same
            one = dataclasses.replace(one, **_no_speed(one))
        made.append(motion_of(one, in_one, source, mode, rate))
    for other, source in zip(made, sources, strict=True):
        if (other.effort_name, other.effort_unit) != (made[0].effort_name, made[0].effort_unit):
            raise InputError(
                f"{source}: the effort is a {other.effort_name} in {other.effort_unit}, in "
                f"{sources[0]} a {made[0].effort_name} in {made[0].effort_unit}; expected one kind "
                "in all recordings of one machine (actuation.signal in the drive file)"
            )
    return tuple(made)


def _no_speed(recording: Recording) -> dict[str, Any]:
    names = ("rod_velocity_m_per_s", "rotor_velocity_rad_per_s", "load_velocity_rad_per_s")
    return {name: np.full(len(recording), np.nan) for name in names}


def joined(motions: Sequence[Motion], sources: Sequence[str]) -> Joined:
    """The motions as one; they share rate and band."""
    sizes = [one.time_s.size for one in motions]
    ends = np.cumsum(sizes)
    spans = tuple(slice(int(end) - size, int(end)) for end, size in zip(ends, sizes, strict=True))
    lengths = [float(one.time_s[-1]) for one in motions]
    # Of n recordings, with this between two, a stretch is a 48th of all at the most.
    pause = max(2.0 * STRETCH_S, sum(lengths) / max(MOST_STRETCHES - len(motions), 1))
    times, begin = [], 0.0
    for one, length in zip(motions, lengths, strict=True):
        times.append(one.time_s + begin)
        begin += length + pause
    first = motions[0]
    values: dict[str, Any] = {
        one.name: getattr(first, one.name) for one in dataclasses.fields(first)
    }
    for name, value in values.items():
        if isinstance(value, np.ndarray) and not name.startswith("_"):
            values[name] = np.concatenate([getattr(one, name) for one in motions])
    values |= {
        "time_s": np.concatenate(times),
        "position_noise": _rms([one.position_noise for one in motions]),
        "rounding": _rms([one.rounding for one in motions]),
        "speed_noise": _rms([one.speed_noise for one in motions]),
        "standing": float(np.average([one.standing for one in motions], weights=sizes)),
        "notes": tuple(
            f"{source}: {note}"
            for one, source in zip(motions, sources, strict=True)
            for note in one.notes
        ),
        "caution": "; ".join(
            f"{source}: {one.caution}"
            for one, source in zip(motions, sources, strict=True)
            if one.caution
        ),
    }
    return Joined(**values, spans=spans, noise=np.ones(len(spans)))


def in_own_noise(motion: Joined, motions: Sequence[Motion], inertia: float) -> Joined:
    """The motion with each recording counted in its own noise.

    What noise of effort and motion comes to, for an output of `inertia`, as all are weighed.
    """
    hertz = weighed(motion, inertia).weight_hz
    motions = [dataclasses.replace(one, weight_hz=hertz) for one in motions]
    finest = _FINEST * float(np.std(motion.effort[motion.usable]))
    noise = np.array(
        [
            math.hypot(effort_noise(one), inertia * acceleration_noise(one, rounded=True), finest)
            for one in motions
        ]
    )
    return dataclasses.replace(motion, noise=noise / _rms(noise.tolist()))


def _rms(values: Sequence[float]) -> float:
    return float(np.sqrt(np.mean(np.square(values))))
