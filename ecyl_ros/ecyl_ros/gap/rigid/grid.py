"""A recording's signals on one even grid, and where they are to be trusted."""

from __future__ import annotations

import math

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from ...arrays import BoolArray, FloatArray
from ...errors import InputError
from ...recording.runs import runs_of
from ...recording.signals import Recording

_HUGE = 1e12  # in SI: larger values are no measurement
_LONGEST_GAP = 5  # missing samples in a row that are bridged
_MOST_BENT, _JUMP = 0.999, 3.0  # of the second differences; beyond so many times it is a jump
_FROZEN, _FROZEN_S = 20, 0.25  # samples and seconds for which an effort has to stand still
_RUNS = 10  # runs of equal values, with which they are usual
_LIVELY = 0.5  # share of the other samples at which it changes
_MOVED = 0.01  # of the travel, that the output has to move meanwhile
_ROUNDED = 1e-3  # of a sample
_EVEN = 0.02  # steps of the stamps may differ by this share and still be called even


def even_grid(
    recording: Recording, source: str, rate_hz: float | None = None
) -> tuple[FloatArray, float, list[str]]:
    """Instants in s, their rate in Hz, and what was found odd of the stamps.

    rate_hz: that the grid is to have; the recording's own unless given.
    """
    if len(recording) < 64:
        raise InputError(f"{source}: {len(recording)} samples, expected at least 64")
    steps = np.diff(recording.time_s)
    typical = float(np.median(steps))
    # A mean over all but the longest pauses does not round as a median of stamps in ms does.
    usual = steps[steps < 3.0 * typical]
    rate = 1.0 / float(usual.mean())
    asked = rate_hz or rate
    grid = np.arange(math.floor(recording.duration_s * asked + 1e-6) + 1) / asked
    notes = []
    uneven = int(np.sum(np.abs(usual * rate - 1.0) > _EVEN))
    if uneven:
        notes.append(
            f"uneven stamps: {uneven} of {steps.size} steps are off {1e3 / rate:.3g} ms by "
            f"more than {100.0 * _EVEN:.0f} %; everything was put on an even grid"
        )
    return grid, asked, notes


class Taker:
    """Signals of a recording on an even grid."""

    def __init__(self, recording: Recording, grid: FloatArray, rate: float) -> None:
        self._recording, self._grid, self.rate_hz = recording, grid, rate

    def __call__(self, name: str) -> FloatArray:
        """Linear between samples; NaN where the nearest one is too far or unknown."""
        values = self._recording.signal(name)
        known = np.isfinite(values)
        known[known] = np.abs(values[known]) < _HUGE
        if known.sum() < 2:
            return np.full(self._grid.size, np.nan)
        times = self._recording.time_s[known]
        # An instant at either end is that of the sample there, but for how stamps are rounded.
        slack = _ROUNDED / self.rate_hz
        made = np.interp(self._grid, times, values[known])
        made[(self._grid < times[0] - slack) | (self._grid > times[-1] + slack)] = np.nan
        after = np.clip(np.searchsorted(times, self._grid), 1, times.size - 1)
        made[times[after] - times[after - 1] > (_LONGEST_GAP + 1.5) / self.rate_hz] = np.nan
        return made

    def held(self, name: str) -> FloatArray:
        """The last value at or before each instant: for what switches."""
        values = self._recording.signal(name)
        known = np.isfinite(values)
        if not known.any():
            return np.full(self._grid.size, np.nan)
        times = self._recording.time_s[known]
        last = np.searchsorted(times, self._grid + 1e-9, side="right") - 1
        return np.where(last >= 0, values[known][np.maximum(last, 0)], np.nan)


def bridged(values: FloatArray, known: BoolArray) -> FloatArray:
    """Straight lines where a value is not known."""
    index = np.arange(values.size)
    return np.interp(index, index[known], values[known])


def carried_on(position: FloatArray, known: BoolArray, within: int) -> FloatArray:
    """Cubics where a position is not known, as fast at either end as it is there.

    A straight line would turn off at once: a blow of acceleration, that filters carry far.

    within: samples beside a gap that its speed there is told from.
    """
    made = bridged(position, known)
    gaps = runs_of(~known)
    for begin, end in gaps[(gaps[:, 0] > 0) & (gaps[:, 1] < known.size)].tolist():
        before, after = (
            _slope(made, known, range(begin - 1, max(begin - 1 - within, -1), -1)),
            _slope(made, known, range(end, min(end + within, known.size))),
        )
        ends = CubicHermiteSpline((begin - 1, end), made[[begin - 1, end]], (before, after))
        made[begin:end] = ends(np.arange(begin, end))
    return made


def _slope(values: FloatArray, known: BoolArray, side: range) -> float:
    """Per sample at the first of some samples, by a parabola through those that are known."""
    rows = np.array(side)
    rows = rows[np.cumprod(known[rows]).astype(bool)]
    if rows.size < 2:
        return 0.0
    return float(np.polyfit(rows - rows[0], values[rows], min(2, rows.size - 1))[-2])


def wide(known: BoolArray, rate: float) -> BoolArray:
    """False only where more than a few samples in a row are missing."""
    return ~eroded(~known, _LONGEST_GAP // 2 + 1, outside=False) | known


def eroded(mask: BoolArray, by: int, outside: bool = True) -> BoolArray:
    """True where all samples within `by` are; beyond the ends counts as False if `outside`."""
    padded = np.concatenate([np.full(by, not outside), mask, np.full(by, not outside)])
    summed = np.concatenate([[0], np.cumsum(~padded)])
    width = 2 * by + 1
    clear: BoolArray = summed[width:] - summed[:-width] == 0
    return clear


def standing_effort(
    effort: FloatArray, position: FloatArray, noise: float, rate: float
) -> BoolArray:
    """Where the effort is the very same for long while the output moves: it was not measured.

    At its largest value it is a limit, and rightly the same. An effort of few levels stands often:
    then long is long beside its other rests.
    """
    size = float(np.max(np.abs(effort), initial=0.0))
    same = np.concatenate([[False], np.abs(np.diff(effort)) <= 1e-12 * max(size, 1e-300), [False]])
    bounds = np.flatnonzero(np.diff(same.astype(np.int8))).reshape(-1, 2)
    found = np.zeros(effort.size, dtype=bool)
    lengths = bounds[:, 1] - bounds[:, 0]
    usual = float(np.quantile(lengths, 0.9)) if lengths.size >= _RUNS else 1.0
    away = max(100.0 * noise, _MOVED * float(np.ptp(position)))
    for begin, end in bounds.tolist():
        part = slice(begin, end)
        long = end - begin >= max(_FROZEN_S * rate, _FROZEN, 3.0 * usual)
        limit = abs(effort[begin]) >= (1.0 - 1e-9) * size and size > 0.0
        if long and not limit and float(np.ptp(position[part])) > away:
            found[part] = True
    # An effort commanded in steps stands all the time: only one that else changes is not measured.
    changes = ~same[:-1][~found]
    return found if changes.size and float(np.mean(changes)) > _LIVELY else np.zeros_like(found)


def jumped(position: FloatArray, usable: BoolArray) -> BoolArray:
    """Samples beside a second difference far beyond all others of the recording."""
    bend = np.zeros(position.size)
    bend[1:-1] = np.abs(np.diff(position, 2))
    limit = _JUMP * float(np.quantile(bend[usable], _MOST_BENT)) if usable.any() else 0.0
    beyond = bend > (limit if limit > 0.0 else math.inf)
    return ~eroded(~beyond, 2, outside=False) if beyond.any() else beyond
