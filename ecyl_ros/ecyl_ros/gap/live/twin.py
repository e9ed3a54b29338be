"""The nominal closed loop, tick by tick along a reference that is still being made."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from ...arrays import FloatArray, StampArray
from ...drive.cascade import initial_cascade_state
from ...drive.engine import COLUMNS, run_ticks
from ...drive.packed import pack
from ...drive.parameters import DriveParameters
from ...drive.plant import MEASURED, voltage_queue
from ..replay.sensor_noise import declared_noise, silent
from .start import State

_DRAWS = 3  # loops with noise: of one alone, what rare impacts make of it would be chance
_POINTS = 4  # of the cubic between ticks
_ON_TICK = 0.01  # of a tick: stamps this near to a tick are at it


class _Loop:
    """One run of the engine that goes on from batch to batch."""

    def __init__(self, drive: DriveParameters, state: State, draw: int = 0) -> None:
        """draw: loops of another one have other noise."""
        self._draw = draw
        self._params = pack(drive)
        self._plant = state.plant.copy()
        self._cascade = initial_cascade_state(self._params)
        self._cascade[0][:] = state.integrals
        self._pending = voltage_queue(self._params)
        self._pending[:] = state.voltage
        self._scratch = np.zeros(len(MEASURED))
        self._batches = 0

    def advance(self, reference: FloatArray) -> FloatArray:
        """float64[n, COLUMNS] at the next n ticks; reference: float64[n + 1, 2]."""
        ticks = len(reference) - 1
        samples = np.zeros((ticks, COLUMNS))
        # Ticks count from 0 in every batch; noise is drawn by tick, so each has a seed of its own.
        self._batches += 1
        self._params["noise_seed"] = self._batches * _DRAWS + self._draw
        run_ticks(
            0,
            ticks,
            1,
            reference,
            self._plant,
            self._cascade,
            self._pending,
            self._params,
            samples,
            self._scratch,
        )
        return samples


class Twin:
    """The model of a drive file in closed loop, begun at one instant of the real drive's time.

    Beside the model without noise run a few with the stated noise of its sensors: what they differ
    by is what noise alone leaves, also by way of the loop and of impacts that it shifts.

    Attributes:
        begin_ns: stamp of tick 0. ticks: run so far.
    """

    def __init__(self, drive: DriveParameters, begin_ns: int, state: State) -> None:
        self.begin_ns = begin_ns
        self.ticks = 0
        self._rate = drive.controller.rate
        self._loop = _Loop(silent(drive), state)
        noisy = any(declared_noise(drive).values())
        self._noisy = [_Loop(drive, state, draw) for draw in range(_DRAWS)] if noisy else []
        self._rows = np.zeros((0, COLUMNS))
        self._noise_rows = [np.zeros((0, COLUMNS)) for _ in self._noisy]
        self._first_row = 0  # tick of the first of `_rows`

    def _tick(self, stamp_ns: StampArray) -> FloatArray:
        """Stamps in ticks, broken ones too."""
        return np.asarray((stamp_ns - self.begin_ns) * (self._rate / 1e9), dtype=np.float64)

    def tick_of(self, stamp_ns: int) -> int:
        """The last tick at or before a stamp."""
        return int((stamp_ns - self.begin_ns) * self._rate / 1e9 + _ON_TICK)

    def advance(
        self, last_tick: int, stamp_ns: StampArray, position: FloatArray, velocity: FloatArray
    ) -> None:
        """Run all ticks up to and with `last_tick`.

        stamp_ns, position, velocity: reference samples, m and m/s, around those ticks. Between
        them the reference goes as the drive's own controller has it.
        """
        ticks = np.arange(self.ticks, last_tick + 2)
        reference = _between(self._tick(stamp_ns), position, velocity, ticks, self._rate)
        kept = max(0, len(self._rows) - _POINTS)
        self._first_row += kept
        self._rows = np.concatenate([self._rows[kept:], self._loop.advance(reference)])
        self._noise_rows = [
            np.concatenate([rows[kept:], loop.advance(reference)])
            for rows, loop in zip(self._noise_rows, self._noisy, strict=True)
        ]
        self.ticks = last_tick + 1

    def ready(self, stamp_ns: StampArray) -> int:
        """How many of these increasing stamps `at` can give."""
        tick = self._tick(stamp_ns)
        needed = np.where(_on_tick(tick), np.round(tick), np.floor(tick) + 2.0)
        return int(np.searchsorted(np.maximum.accumulate(needed), self.ticks - 1, side="right"))

    def at(self, stamp_ns: StampArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """The engine's columns, what noise adds in one draw, and its mean square over the draws.

        Each float64[n, COLUMNS], NaN before the first tick; between ticks by a cubic through four.
        """
        tick = self._tick(stamp_ns) - self._first_row
        clean = _pick(self._rows, tick)
        drawn, square = np.zeros_like(clean), np.zeros_like(clean)
        for rows in self._noise_rows:
            drawn = _pick(rows, tick) - clean
            square += drawn**2 / _DRAWS
        return clean, drawn, square


def _on_tick(tick: FloatArray) -> np.ndarray:
    on: np.ndarray = np.abs(tick - np.round(tick)) < _ON_TICK
    return on


def _pick(rows: FloatArray, tick: FloatArray) -> FloatArray:
    """Rows at broken indices, float64[n, columns]; NaN outside."""
    found = np.full((len(tick), rows.shape[1]), np.nan)
    whole = np.round(tick).astype(np.int64)
    exact = _on_tick(tick) & (whole >= 0) & (whole < len(rows))
    found[exact] = rows[whole[exact]]
    first = np.floor(tick).astype(np.int64) - 1
    between = ~_on_tick(tick) & (first >= 0) & (first + _POINTS <= len(rows))
    if between.any():
        part = (tick[between] - np.floor(tick[between]))[:, None]
        a, b, c, d = (rows[first[between] + point] for point in range(_POINTS))
        # Lagrange's cubic through the points -1, 0, 1, 2.
        found[between] = (
            -part * (part - 1.0) * (part - 2.0) / 6.0 * a
            + (part + 1.0) * (part - 1.0) * (part - 2.0) / 2.0 * b
            - (part + 1.0) * part * (part - 2.0) / 2.0 * c
            + (part + 1.0) * part * (part - 1.0) / 6.0 * d
        )
    return found


def _between(
    at: FloatArray, position: FloatArray, velocity: FloatArray, ticks: np.ndarray, rate: float
) -> FloatArray:
    """Reference at ticks, float64[n, 2]: the cubic with the velocities given, else the line.

    at: float64[m], instants of the reference's samples in ticks. The last sample is held.
    """
    ticks = np.clip(ticks, at[0], at[-1])
    if len(at) < 2:
        return np.column_stack([np.full(len(ticks), position[0]), np.zeros(len(ticks))])
    row = np.clip(np.searchsorted(at, ticks, side="right") - 1, 0, len(at) - 2)
    slope = np.diff(position) / np.diff(at) * rate
    if np.isfinite(velocity).all():
        cubic = CubicHermiteSpline(at / rate, position, velocity)
        return np.column_stack([cubic(ticks / rate), cubic(ticks / rate, 1)])
    rise = np.interp(ticks, at, position)
    known = np.where(np.isfinite(velocity[row]), velocity[row], slope[row])
    return np.column_stack([rise, np.where(ticks == at[row], known, slope[row])])
