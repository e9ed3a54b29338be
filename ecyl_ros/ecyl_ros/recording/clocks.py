"""Stamps as they are: steps, gaps, repeats, clocks that differ and drift, piece by piece."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray, StampArray
from ..typical import typical_rms

LOST = 1.5  # steps; a longer one means that samples are missing
JUMP_NS = 1_000_000_000  # a stamp that goes back further is a clock that was set, not a disorder
_WINDOWS = 400  # of a clock's offset, at most
_WINDOW_NS = 1_000_000_000  # the first width of these
_SAMPLED = 4096  # steps of each piece that the median is taken from
_MOST_SAMPLED = 400_000
_LONGEST = 10  # gaps kept


@dataclass(frozen=True)
class StampFigures:
    """What `StampMeter` found.

    Attributes:
        count: stamps.
        first_ns, last_ns: lowest and highest.
        step_s: median of the steps that lead on; NaN with fewer than two stamps.
        jitter_s: half the width of the middle 90 % of these steps.
        repeated, backward: stamps equal to the one before; below the highest before.
        jumps: steps back by more than a second.
        lost: samples that longer steps leave out, by the median step.
        gaps: (seconds after the first stamp, length in s) of the longest pauses, longest first.
    """

    count: int
    first_ns: int
    last_ns: int
    step_s: float
    jitter_s: float
    repeated: int
    backward: int
    jumps: int
    lost: int
    gaps: tuple[tuple[float, float], ...]

    @property
    def rate_hz(self) -> float:
        """1 over the median step."""
        return 1.0 / self.step_s if self.step_s > 0.0 else math.nan

    @property
    def span_s(self) -> float:
        """From the lowest to the highest stamp."""
        return (self.last_ns - self.first_ns) / 1e9


class StampMeter:
    """Takes one topic's stamps piece by piece, in file order, and keeps figures alone."""

    def __init__(self) -> None:
        self._count = self._repeated = self._backward = self._jumps = 0
        self._lost = 0
        self._last: int | None = None
        self._high = self._low = 0
        self._steps: list[NDArray[np.int64]] = []
        self._kept = 0
        self._median = 0.0
        self._gaps: list[tuple[int, int]] = []

    def take(self, stamps_ns: StampArray) -> None:
        """The next stamps."""
        if not stamps_ns.size:
            return
        if self._last is None:
            self._last = self._high = self._low = int(stamps_ns[0])
            first = True
        else:
            first = False
        self._count += stamps_ns.size
        before = np.concatenate([[self._last], stamps_ns])
        steps = np.diff(before)[1 if first else 0 :]
        at = before[1 if first else 0 : -1]
        self._repeated += int((steps == 0).sum())
        highest = np.maximum.accumulate(np.concatenate([[self._high], stamps_ns]))
        self._backward += int((stamps_ns < highest[:-1]).sum())
        self._jumps += int((steps < -JUMP_NS).sum())
        self._high = int(highest[-1])
        self._low = min(self._low, int(stamps_ns.min()))
        self._last = int(stamps_ns[-1])
        ahead = steps[steps > 0]
        if ahead.size and self._kept < _MOST_SAMPLED:
            self._steps.append(ahead[:_SAMPLED].copy())
            self._kept += self._steps[-1].size
            if not self._median or self._kept < 4 * _SAMPLED:
                self._median = float(np.median(np.concatenate(self._steps)))
        if self._median:
            long = steps > LOST * self._median
            if long.any():
                self._lost += int(np.round(steps[long] / self._median - 1.0).sum())
                found = zip(steps[long].tolist(), at[long].tolist(), strict=True)
                # Many: the longest of them, before they are sorted with those of before.
                self._gaps = sorted([*self._gaps, *found], reverse=True)[:_LONGEST]

    def figures(self) -> StampFigures:
        """Of all stamps taken."""
        steps = np.concatenate(self._steps) / 1e9 if self._steps else np.zeros(0)
        low, mid, high = np.percentile(steps, [5, 50, 95]) if steps.size else (math.nan,) * 3
        return StampFigures(
            count=self._count,
            first_ns=self._low,
            last_ns=self._high,
            step_s=float(mid),
            jitter_s=float(high - low) / 2.0,
            repeated=self._repeated,
            backward=self._backward,
            jumps=self._jumps,
            lost=self._lost,
            gaps=tuple(((at - self._low) / 1e9, step / 1e9) for step, at in self._gaps),
        )


@dataclass(frozen=True)
class ClockFit:
    """How the recorder's clock runs against that of a topic's stamps.

    Log time less stamp is the clocks' difference and a transport delay, which is never negative:
    so the line is laid through the least differences of stretches of time (Theil and Sen's: the
    median of all slopes between them).

    Attributes:
        origin_ns: stamp at which `offset_s` holds.
        offset_s: log time less stamp.
        drift: by how many s per s that grows.
        drift_error: standard error of the drift.
        delay_s: median of what is above the line: transport, beyond its least.
    """

    origin_ns: int
    offset_s: float
    drift: float
    drift_error: float
    delay_s: float

    def offset_at(self, stamps_ns: StampArray) -> FloatArray:
        """Log time less stamp in s, without the transport's variations."""
        since: FloatArray = self.offset_s + self.drift * ((stamps_ns - self.origin_ns) / 1e9)
        return since


class ClockMeter:
    """Takes stamps and log times of one topic piece by piece; fits one against the other."""

    def __init__(self) -> None:
        self._origin: int | None = None
        self._width = _WINDOW_NS
        self._least: dict[int, tuple[int, int, float, int]] = {}  # least, its stamp, sum, count

    def take(self, stamps_ns: StampArray, log_ns: StampArray) -> None:
        """The next of both, int64[n] each. Stamps that are none (0 or less) are left out."""
        good = stamps_ns > 0
        stamps, log = stamps_ns[good], log_ns[good]
        if not stamps.size:
            return
        if self._origin is None:
            self._origin = int(log[0])
        windows = (log - self._origin) // self._width
        order = np.argsort(windows, kind="stable")
        windows, stamps, log = windows[order], stamps[order], log[order]
        # Counted from the first, so that sums stay small and exact.
        difference = log - stamps
        edges = np.flatnonzero(np.diff(windows)) + 1
        for part in np.split(np.arange(windows.size), edges):
            key = int(windows[part[0]])
            own = difference[part]
            place = int(np.argmin(own))
            low, at = int(own[place]), int(stamps[part[place]])
            known = self._least.get(key)
            # The sample's median stands for the window's: delays vary from message to message.
            middle = float(np.median(own - low)) / 1e9
            if known is None:
                self._least[key] = (low, at, middle * own.size, own.size)
            else:
                best = (low, at) if low < known[0] else known[:2]
                total = known[2] + (middle + (low - best[0]) / 1e9) * own.size
                self._least[key] = (*best, total, known[3] + own.size)
        if len(self._least) > _WINDOWS:
            self._halve()

    def _halve(self) -> None:
        """Join neighbouring windows, so that their number stays bounded."""
        self._width *= 2
        joined: dict[int, tuple[int, int, float, int]] = {}
        for key, own in self._least.items():
            known = joined.get(key // 2)
            if known is None:
                joined[key // 2] = own
            else:
                best = min(own[:2], known[:2])
                joined[key // 2] = (*best, own[2] + known[2], own[3] + known[3])
        self._least = joined
        if len(self._least) > _WINDOWS:
            self._halve()

    def fit(self) -> ClockFit | None:
        """The line; None before anything was taken."""
        if not self._least:
            return None
        parts = [self._least[key] for key in sorted(self._least)]
        most = max(part[3] for part in parts)
        parts = [part for part in parts if part[3] >= 0.2 * most]  # a half window has no least yet
        base = parts[0][0]
        stamps = np.array([part[1] for part in parts], dtype=np.int64)
        offsets = np.array([part[0] - base for part in parts], dtype=np.float64) / 1e9
        origin = int(stamps[0])
        seconds = (stamps - origin) / 1e9
        delay = sum(part[2] for part in parts) / sum(part[3] for part in parts)
        slope = error = 0.0
        start = float(np.median(offsets))
        if len(parts) >= 5 and float(np.ptp(seconds)) > 0.0:
            from scipy.stats import theilslopes

            found = theilslopes(offsets, seconds)
            slope = float(found.slope)
            start = float(found.intercept)
            left = offsets - start - slope * seconds
            scatter = typical_rms(left)
            error = scatter / (float(np.std(seconds)) * math.sqrt(len(parts))) + 1e-12
        return ClockFit(origin, base / 1e9 + start, slope, error, delay)


def longest_run(stamps_ns: StampArray, log_ns: StampArray | None) -> tuple[slice, int]:
    """The longest part between settings of the clock, and how often it was set.

    A clock was set where stamps go back by more than a second, or go on by more than a second
    while the recorder's clock hardly does.
    """
    steps = np.diff(stamps_ns)
    broken = steps < -JUMP_NS
    if log_ns is not None:
        broken |= (steps > JUMP_NS) & (np.diff(log_ns) < 0.1 * steps)
    edges = np.concatenate([[0], np.flatnonzero(broken) + 1, [stamps_ns.size]])
    longest = int(np.argmax(np.diff(edges)))
    return slice(int(edges[longest]), int(edges[longest + 1])), int(broken.sum())


def steadied(stamps_ns: StampArray, limit: float) -> tuple[StampArray, float] | None:
    """Arrival times put back to the even beat in which the samples were taken.

    Samples that are taken evenly arrive unevenly. Between pauses the k-th is taken to have been
    due at start + k x step, by the line under all arrivals: the least delayed stand on it.

    Args:
        stamps_ns: increasing arrival times.
        limit: in steps; a longer pause begins a new beat.

    Returns:
        The due times and the RMS of what was subtracted, in s; None where arrivals stray from a
        beat by more than `limit` steps, so that there is none.
    """
    steps = np.diff(stamps_ns)
    if steps.size < 50:
        return None
    # Arrivals in bunches spoil the median; between pauses the mean is the beat.
    step = float(np.median(steps[steps > 0])) if (steps > 0).any() else 0.0
    step = max(step, float(np.mean(steps[steps < 10.0 * np.mean(steps)])))
    edges = np.concatenate(
        [[0], np.flatnonzero(steps > max(limit, 2.0) * step) + 1, [stamps_ns.size]]
    )
    due = np.array(stamps_ns, dtype=np.int64)
    moved = 0.0
    for begin, end in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True):
        own = stamps_ns[begin:end]
        if own.size < 50:
            continue
        index = np.arange(own.size, dtype=np.float64)
        seconds = (own - own[0]).astype(np.float64)
        slope, start = np.polyfit(index, seconds, 1)
        left = seconds - (start + slope * index)
        if slope <= 0.0 or float(np.ptp(left)) > 2.0 * limit * slope:
            return None
        line = start + float(left.min()) + slope * index
        moved += float(((seconds - line) ** 2).sum())
        due[begin:end] = own[0] + np.round(line).astype(np.int64)
    if (np.diff(due) <= 0).any():
        return None
    return due, math.sqrt(moved / stamps_ns.size) / 1e9
