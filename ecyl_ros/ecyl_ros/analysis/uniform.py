"""Evenly spaced samples out of stamped ones, which spectrum, EMD and lag need."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import FloatArray
from ..errors import InputError

# Steps that differ from their median by less than this fraction count as even: clock jitter of
# a hundredth of a step moves a line at a tenth of the rate by -50 dB.
EVEN = 0.01
MIN_SAMPLES = 16


@dataclass(frozen=True)
class Uniform:
    """Signals on an even grid.

    Attributes:
        time_s: float64[n], from the first sample used.
        rate_hz: 1 / step.
        signals: float64[n] each, in the order given.
        note: what was interpolated; empty where the samples were even as they came.
    """

    time_s: FloatArray
    rate_hz: float
    signals: tuple[FloatArray, ...]
    note: str = ""


def uniform(time_s: FloatArray, *signals: FloatArray) -> Uniform:
    """Take the instants at which all signals are known; interpolate only where these are uneven.

    Args:
        time_s: float64[n], increasing.
        signals: float64[n] each; NaN where unknown.

    Returns:
        The samples themselves if their steps are even; else linear interpolation to the median
        step, with a note that gives the longest gap bridged.

    Raises:
        InputError: fewer than 16 instants at which all are known.
    """
    known = np.isfinite(np.vstack(signals)).all(axis=0)
    count = int(known.sum())
    if count < MIN_SAMPLES:
        raise InputError(
            f"only {count} samples in which all signals are known, {MIN_SAMPLES} needed"
        )
    time = time_s[known] - time_s[known][0]
    values = [signal[known] for signal in signals]
    steps = np.diff(time)
    step = float(np.median(steps))
    if np.all(np.abs(steps - step) <= EVEN * step):
        mean_step = float(time[-1]) / (count - 1)
        return Uniform(time, 1.0 / mean_step, tuple(values))
    grid: FloatArray = np.arange(int(time[-1] / step + 1e-6) + 1, dtype=np.float64) * step
    note = (
        f"samples are uneven (steps {steps.min() * 1e3:.3g} to {steps.max() * 1e3:.3g} ms): "
        f"interpolated to {1.0 / step:.6g} Hz"
    )
    return Uniform(grid, 1.0 / step, tuple(np.interp(grid, time, v) for v in values), note)
