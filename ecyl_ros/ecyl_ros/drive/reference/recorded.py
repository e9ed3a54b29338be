"""The reference of a recording, played again."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy

from ...errors import InputError
from ...recording.signals import Recording


@dataclass(frozen=True)
class Recorded:
    """Positions and velocities at the recording's own instants, smooth between, held at the end.

    time_s: float64[n] from the first sample. position_m, velocity_m_per_s: float64[n]; where the
    recording holds no velocity a cubic spline through the positions gives it.
    """

    time_s: np.ndarray
    position_m: np.ndarray
    velocity_m_per_s: np.ndarray
    spline: scipy.interpolate.CubicHermiteSpline

    @classmethod
    def from_recording(cls, recording: Recording, source: str) -> Recorded:
        """Take the reference of `recording`; raises InputError if it holds none to play."""
        time, position = recording.time_s, recording.reference_position_m
        known = np.isfinite(position)
        if known.sum() < 2:
            raise InputError(
                f"{source}: /ecyl/reference holds {int(known.sum())} finite positions, "
                "expected at least 2 to play"
            )
        time, position = time[known], position[known]
        velocity = recording.reference_velocity_m_per_s[known]
        if not np.isfinite(velocity).all():
            velocity = scipy.interpolate.CubicSpline(time, position)(time, 1)
        spline = scipy.interpolate.CubicHermiteSpline(time, position, velocity)
        return cls(time, position, velocity, spline)

    @property
    def duration_s(self) -> float:
        """Length of the recorded reference, s."""
        return float(self.time_s[-1])

    def sample(self, time_s: float) -> tuple[float, float]:
        """Position m and velocity m/s at `time_s`; the recorded sample itself where one stands."""
        index = int(np.searchsorted(self.time_s, time_s - 1e-9))
        if index >= len(self.time_s):
            return float(self.position_m[-1]), 0.0
        if abs(self.time_s[index] - time_s) <= 1e-9 or index == 0:
            return float(self.position_m[index]), float(self.velocity_m_per_s[index])
        return float(self.spline(time_s)), float(self.spline(time_s, 1))
