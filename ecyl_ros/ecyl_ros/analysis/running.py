"""Tracking figures while a recording is still running: fed sample by sample, over a window."""

from __future__ import annotations

import importlib
import math
from collections import deque
from dataclasses import dataclass

import numpy as np

from ..errors import InputError
from .lag import Lag, lag_and_gain
from .spectrum import Line, amplitude_spectrum, dominant_lines
from .uniform import MIN_SAMPLES, uniform

# Lag and lines are taken from at most this many samples: sums over neighbours, which also act as
# a low-pass. A window of 4 s keeps 256 Hz, and the figures cost a few ms a second.
FIGURE_SAMPLES = 1024


@dataclass(frozen=True)
class RunningFigures:
    """Figures of the window, SI units; error = reference - position.

    Attributes:
        samples: in the window.
        duration_s: from its first to its last sample.
        error_std_m, error_rms_m, error_max_m: NaN while there is no sample.
        lag: with the reason where it has no meaning, or not enough was heard yet.
        lines: dominant lines of the error, strongest first; empty while there are too few samples.
    """

    samples: int
    duration_s: float
    error_std_m: float
    error_rms_m: float
    error_max_m: float
    lag: Lag
    lines: tuple[Line, ...]


class RunningTracking:
    """Keeps the last `window_s` seconds of reference and position.

    Args:
        window_s: length of the window.
        lines: spectral lines listed at most.
        max_samples: bound on memory, whatever the rate; the window shortens to it.

    Attributes:
        dropped: samples refused: not finite, or with a stamp that does not increase.
        restarts: times the clock jumped back by more than the window (a simulation restarted);
            the window was emptied.
    """

    def __init__(
        self, window_s: float = 4.0, *, lines: int = 5, max_samples: int = 1_000_000
    ) -> None:
        if not (math.isfinite(window_s) and window_s > 0.0):
            raise InputError(f"window is {window_s:g} s, expected more than 0")
        # What the figures need takes half a second to import: now, not between two samples.
        for module in ("scipy.signal", "scipy.interpolate", "scipy.optimize"):
            importlib.import_module(module)
        self._window_ns = round(window_s * 1e9)
        self._lines = lines
        self._stamps: deque[int] = deque(maxlen=max_samples)
        self._reference: deque[float] = deque(maxlen=max_samples)
        self._position: deque[float] = deque(maxlen=max_samples)
        self.dropped = 0
        self.restarts = 0

    def update(self, stamp_ns: int, reference_m: float, position_m: float) -> None:
        """Take in one sample; cost does not depend on the window."""
        stamps = self._stamps
        if stamps and stamp_ns <= stamps[-1]:
            if stamps[-1] - stamp_ns <= self._window_ns:
                self.dropped += 1
                return
            self.clear()
            self.restarts += 1
        # A sum with infinity or NaN in it is not finite either.
        if not math.isfinite(reference_m + position_m):
            self.dropped += 1
            return
        stamps.append(stamp_ns)
        self._reference.append(reference_m)
        self._position.append(position_m)
        oldest = stamp_ns - self._window_ns
        while stamps[0] <= oldest:
            stamps.popleft()
            self._reference.popleft()
            self._position.popleft()

    def clear(self) -> None:
        """Forget the window; the counters stay."""
        self._stamps.clear()
        self._reference.clear()
        self._position.clear()

    def figures(self) -> RunningFigures:
        """Compute the window's figures; meant to be called about once a second."""
        count = len(self._stamps)
        nan = float("nan")
        if count == 0:
            return RunningFigures(0, 0.0, nan, nan, nan, _waiting(), ())
        stamps = np.fromiter(self._stamps, dtype=np.int64, count=count)
        reference = np.fromiter(self._reference, dtype=np.float64, count=count)
        position = np.fromiter(self._position, dtype=np.float64, count=count)
        error = reference - position
        time = (stamps - stamps[0]) / 1e9
        lag = _waiting()
        lines: tuple[Line, ...] = ()
        if count >= MIN_SAMPLES:
            even = uniform(time, reference, position)
            factor = max(1, even.time_s.size // FIGURE_SAMPLES)
            thin_reference = _thinned(even.signals[0], factor)
            thin_position = _thinned(even.signals[1], factor)
            rate = even.rate_hz / factor
            if thin_reference.size >= MIN_SAMPLES:
                lag = lag_and_gain(thin_reference, thin_position, rate)
                spectrum = amplitude_spectrum(thin_reference - thin_position, rate)
                lines = dominant_lines(spectrum, count=self._lines)
        return RunningFigures(
            samples=count,
            duration_s=float(time[-1]),
            error_std_m=float(error.std()),
            error_rms_m=float(np.sqrt(np.mean(error**2))),
            error_max_m=float(np.abs(error).max()),
            lag=lag,
            lines=lines,
        )


def _waiting() -> Lag:
    nan = float("nan")
    return Lag(nan, nan, nan, nan, "not enough samples yet")


def _thinned(values: np.ndarray, factor: int) -> np.ndarray:
    whole = values.size // factor * factor
    return values[:whole].reshape(-1, factor).mean(axis=1)
