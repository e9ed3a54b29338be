"""The samples that a replay computes, and how the recording's stamps and reference lie on them."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicHermiteSpline, CubicSpline

from ...arrays import FloatArray
from ...recording.signals import Recording

_ON_GRID = 0.01  # of a sample: stamps nearer than that to the grid are on it
_ROUNDED_S = 1e-9  # by which stamps are off their ticks that count in ns
_FINE_HZ = 1000.0  # of the grid where they are not


@dataclass(frozen=True, eq=False)
class Grid:
    """Instants that are whole control ticks apart, from the recording's first stamp on.

    Attributes:
        every: control ticks between two instants. step_s: the same in s. samples: how many.
        time_s: float64[n], the recording's stamps.
        rows: int64[n], where these lie on the grid; None where they lie between.
    """

    every: int
    step_s: float
    samples: int
    time_s: FloatArray
    rows: NDArray[np.int64] | None

    @classmethod
    def under(cls, time_s: FloatArray, rate_hz: float, control_hz: float) -> Grid:
        """Under stamps of a recording at `rate_hz` of a drive whose loops run at `control_hz`."""
        ratio = control_hz / rate_hz
        every = max(1, round(ratio))
        rows = _rows(time_s * control_hz / every)
        if abs(ratio / every - 1.0) > _ON_GRID or rows is None:
            # Uneven stamps or another rate: replay finely and interpolate.
            every = max(1, min(every, round(control_hz / _FINE_HZ)))
            rows = _rows(time_s * control_hz / every)
        step = every / control_hz
        samples = math.ceil(time_s[-1] / step - 1e-6) + 1
        return cls(every, step, samples, time_s, rows)

    @property
    def ticks(self) -> int:
        """Control ticks up to the last instant."""
        return (self.samples - 1) * self.every + 1

    def instants(self) -> FloatArray:
        """float64[samples + 1], s: the instants and the one after them."""
        return self.step_s * np.arange(self.samples + 1, dtype=np.float64)

    def of(self, kept: NDArray[np.int64]) -> Grid:
        """For some of the stamps alone; as long as before."""
        rows = None if self.rows is None else self.rows[kept]
        return dataclasses.replace(self, time_s=self.time_s[kept], rows=rows)

    def ended(self) -> Grid:
        """The same, no longer than up to the last stamp."""
        last = math.ceil(float(self.time_s[-1]) / self.step_s - 1e-6) + 1
        return dataclasses.replace(self, samples=min(self.samples, last))

    def on_stamps(self, columns: FloatArray) -> FloatArray:
        """float64[columns, n] at the stamps from float64[grid, columns].

        Of a run that ran away the nearest instants: no spline goes through what is not finite.
        """
        rows = self.rows
        if rows is None and not np.isfinite(columns).all():
            rows = np.clip(np.rint(self.time_s / self.step_s), 0, len(columns) - 1).astype(np.int64)
        if rows is not None:
            return np.ascontiguousarray(columns[rows].T)
        values: FloatArray = CubicSpline(np.arange(len(columns)) * self.step_s, columns)(
            self.time_s
        ).T
        return values

    def reference(self, recording: Recording) -> FloatArray:
        """float64[samples + 1, 2], what the recording asked for at `instants`: m and m/s.

        Asked for at control ticks: a stamp that is next to one has jitter, and a reference that
        moves fast would have it, too.
        """
        position = recording.reference_position_m
        velocity = recording.reference_velocity_m_per_s
        known = np.isfinite(position)
        time: FloatArray = self.time_s[known]
        if self.rows is not None:
            ticks: FloatArray = np.multiply(self.rows[known], self.step_s, dtype=np.float64)
            time = ticks if float(np.max(np.abs(ticks - time))) > _ROUNDED_S else time
        if np.isfinite(velocity[known]).all():
            spline = CubicHermiteSpline(time, position[known], velocity[known])
        else:
            spline = CubicSpline(time, position[known])
        grid = np.clip(self.instants(), time[0], time[-1])
        return np.column_stack([spline(grid), spline(grid, 1)])


def _rows(index: FloatArray) -> NDArray[np.int64] | None:
    """Whole numbers where all of `index` are."""
    whole = np.round(index)
    return whole.astype(np.int64) if bool(np.all(np.abs(index - whole) < _ON_GRID)) else None
