"""Keeping the wall clock: which ticks are due, how late they came, which commands were missing."""

from __future__ import annotations

import dataclasses
import math
from collections import deque
from collections.abc import Sequence
from typing import Any

import numpy as np

from ..drive.parameters import DriveParameters

RECENT = 1000  # ticks, for the figures while running
# Bins that jitter is counted in, a hundred for each factor of ten from 1 us to 10 s, one below and
# one beyond: however long a run lasts it takes no more memory, and quantiles are 1 % off at most.
_SMALLEST_EXPONENT, _DECADES, _PER_DECADE = -6, 7, 100
_QUANTILES = (0.5, 0.99, 0.999)
# Of the histogram that is told: ten for each factor of ten from 10 us to 0.1 s.
_TOLD_EXPONENTS, _TOLD_PER_DECADE = (-5, -1), 10

FEW_MISSED = 0.005  # of the ticks: more are worth a warning
# More than this share of the ticks of so long missed: the loop is no longer the drive file's.
MOST_MISSED, MISSED_S = 0.5, 10.0

# How long input may stay away until the drive is brought to rest: what fieldbus drives commonly
# wait, and more than a hiccup of a desktop's scheduler; at a low control rate some ticks at least.
WATCHDOG_S = 0.1
WATCHDOG_TICKS = 5


def watchdog_ns(rate: float) -> int:
    """The watchdog's time at this control rate (Hz), ns."""
    return round(max(WATCHDOG_S, WATCHDOG_TICKS / rate) * 1e9)


def with_transport_delay(drive: DriveParameters, logger: Any = None) -> DriveParameters:
    """The drive with at least the one tick of delay that a command on a topic has.

    logger: of a node, which says so where the drive file has none.
    """
    if drive.controller.delay_ticks >= 1:
        return drive
    if logger is not None:
        logger.warning(
            "controller.delay_ticks = 0: in real time a command acts one tick after its "
            "measurement; running with 1"
        )
    return dataclasses.replace(
        drive, controller=dataclasses.replace(drive.controller, delay_ticks=1)
    )


class TickTiming:
    """Counts of a real-time run.

    A tick is *late* when the plant woke more than one period after its instant, and *stale* when
    the command for it had not come; a tick that is neither is met. Jitter is the time from a
    tick's instant to the wake-up that served it.
    """

    def __init__(self, rate: float) -> None:
        """rate: control rate, Hz."""
        self.rate = rate
        self.late = 0
        self.stale = 0
        self.missed = 0
        # Ticks, and those missed of them, at each call of `since_last` within `MISSED_S`.
        self._counts: deque[tuple[int, int]] = deque([(0, 0)])
        self.shorted = 0  # times the watchdog took the voltage away
        self.recent_s: deque[float] = deque(maxlen=RECENT)  # jitter of the newest ticks
        self._jitter_counts = [0] * (_DECADES * _PER_DECADE + 2)
        self._begin = 0.0
        self._command_ns = -1
        self._due = 0
        self._largest_s = 0.0

    def start(self, instant: float) -> None:
        """instant: of tick 0 on the monotonic clock, s."""
        self._begin = instant

    def wake(self, now: float, tick: int) -> int:
        """Number of ticks due at `now`, `tick` being the first not yet served; notes jitter."""
        due = int((now - self._begin) * self.rate) + 1 - tick
        for behind in range(max(due, 0)):
            lateness = now - (self._begin + (tick + behind) / self.rate)
            self.recent_s.append(lateness)
            self._jitter_counts[_bin(lateness)] += 1
            if lateness > self._largest_s:
                self._largest_s = lateness
        self._due = due
        return max(due, 0)

    def command(self, stamp_ns: int) -> None:
        """Note the stamp of the newest command, ns."""
        self._command_ns = stamp_ns

    def latch(self, wanted_ns: int) -> None:
        """Serve one due tick, whose command should be the one stamped `wanted_ns`."""
        late = self._due > 1
        stale = self._command_ns < wanted_ns
        self.late += late
        self.stale += stale
        self.missed += late or stale
        self._due -= 1

    def since_last(self, ticks: int) -> float:
        """Share of missed ticks since the last call; `ticks` were served so far."""
        before, before_missed = self._counts[-1]
        self._counts.append((ticks, self.missed))
        while ticks - self._counts[1][0] >= MISSED_S * self.rate:
            self._counts.popleft()
        return (self.missed - before_missed) / max(ticks - before, 1)

    def too_many(self) -> str | None:
        """Says so where most ticks were missed for long, as far as `since_last` was told."""
        (first, early), (last, late) = self._counts[0], self._counts[-1]
        ticks, missed = last - first, late - early
        if ticks < MISSED_S * self.rate or missed <= MOST_MISSED * ticks:
            return None
        return f"{missed} of the latest {ticks} ticks were missed"

    def _figures(self, ticks: int, quantiles_s: Sequence[float]) -> dict:
        p50, p99, p999 = quantiles_s
        return {
            "late_ticks": self.late,
            "stale_ticks": self.stale,
            "missed_ticks": self.missed,
            "voltage_losses": self.shorted,
            "met_share": 1.0 - self.missed / max(ticks, 1),
            "jitter_p50_s": p50,
            "jitter_p99_s": p99,
            "jitter_p999_s": p999,
            "jitter_max_s": self._largest_s,
        }

    def running_figures(self, ticks: int) -> dict:
        """Counts and largest jitter so far, jitter quantiles of the last `RECENT` ticks, s.

        Cheap enough to be asked for between two ticks.
        """
        recent = np.array(self.recent_s or [0.0])
        return self._figures(ticks, np.quantile(recent, _QUANTILES).tolist())

    def figures(self, ticks: int) -> dict:
        """The same over the whole run, and a histogram of jitter (edges in s, counts)."""
        counts = np.array(self._jitter_counts)
        quantiles = [0.0] * len(_QUANTILES)
        if counts.any():
            reached = np.cumsum(counts) / counts.sum()
            inside = [int(np.argmax(reached >= quantile)) for quantile in _QUANTILES]
            quantiles = [min(_middle(index), self._largest_s) for index in inside]
        low, high = _TOLD_EXPONENTS
        finer = _PER_DECADE // _TOLD_PER_DECADE
        first = (low - _SMALLEST_EXPONENT) * _PER_DECADE + 1
        last = (high - _SMALLEST_EXPONENT) * _PER_DECADE + 1
        told = [counts[:first].sum(), *counts[first:last].reshape(-1, finer).sum(axis=1)]
        edges = np.logspace(low, high, _TOLD_PER_DECADE * (high - low) + 1)
        histogram = {
            "edges_s": edges.tolist(),
            "counts": [int(count) for count in (*told, counts[last:].sum())],
        }
        return self._figures(ticks, quantiles) | {"jitter_histogram": histogram}


def _bin(lateness_s: float) -> int:
    if lateness_s < 10.0**_SMALLEST_EXPONENT:
        return 0
    place = int((math.log10(lateness_s) - _SMALLEST_EXPONENT) * _PER_DECADE)
    return min(place, _DECADES * _PER_DECADE) + 1


def _middle(index: int) -> float:
    """The geometric middle of a bin, s."""
    return 10.0 ** (_SMALLEST_EXPONENT + (index - 0.5) / _PER_DECADE) if index else 0.0
