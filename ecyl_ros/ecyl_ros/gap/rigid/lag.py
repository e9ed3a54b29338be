"""Lag between effort and motion: what sampling makes of it, and what is later than that.

A command is held for a period after it was recorded, a speed is a difference over two, a logger
reads one signal after the other: up to two samples either way are of any recording.
"""

from __future__ import annotations

import math

import numpy as np

from ...arrays import BoolArray, FloatArray
from ...effects import actuation_delay
from ...effects.actuation_delay import LAG, LATE
from ...effects.along import Along
from .balance import beside
from .motion import Motion
from .solution import Solution

MOVED = 0.25  # samples: a lag found to be off by more has effects compete again
_FINE = 4  # steps per sample of a search
_BEYOND = 3.0  # samples searched, so that a lag of more than sampling's is seen to be that
_LONGEST_S = 0.1  # delay searched


def sampling_lag(motion: Motion, along: Along, rows: BoolArray) -> float:
    """Seconds by which the recorded effort is ahead of the motion by way of sampling.

    0 where what suits the motion best is further off, for then something is late.

    rows: bool[m], compared samples to judge by.
    """
    columns = motion.filtered(along.smooth()).T[rows]
    period = 1.0 / motion.rate_hz
    tried = along.model.delay_s + _steps(-_BEYOND, _BEYOND) * period
    shifted = motion.shifted(motion.effort, tried)[:, rows]
    left = np.mean(beside(shifted.T, columns) ** 2, axis=0)
    return in_bounds(motion, _lowest(tried, left) - along.model.delay_s)


def in_bounds(motion: Motion, lag_s: float) -> float:
    """A lag that may be of sampling; else 0. A search in noise is off by a little."""
    return lag_s if abs(lag_s) <= (LATE + 1.0 / _FINE) / motion.rate_hz else 0.0


def lag_left(fit: Solution, lag_s: float) -> float:
    """Seconds of lag that a fit finds on top of `lag_s`.

    Beside the null, or as a delay that with it is no later than sampling makes it.
    """
    for one in fit.terms:
        value = float(fit.of(one)[0])
        sampled = lag_s + value <= one.least
        if one.key == LAG or (one.effect == actuation_delay.EFFECT.name and sampled):
            return value
    return 0.0


def delay_of(motion: Motion, effort: FloatArray, explained: FloatArray, rows: BoolArray) -> float:
    """Seconds by which an effort, float64[m], is ahead of what explains it, float64[n]; from 0 on.

    rows: bool[m], to judge by.
    """
    period = 1.0 / motion.rate_hz
    tried = _steps(0.0, max(_LONGEST_S * motion.rate_hz, 2.0 * _BEYOND), 1) * period
    # Later is what was explained before: earlier, what will be.
    shifted = motion.shifted(explained, -tried)[:, rows]
    return max(_lowest(tried, np.mean((effort[rows] - shifted) ** 2, axis=1)), 0.0)


def _steps(first: float, last: float, fine: int = _FINE) -> FloatArray:
    return np.arange(math.floor(first * fine), math.ceil(last * fine) + 1) / fine


def _lowest(tried: FloatArray, left: FloatArray) -> float:
    """Where a parabola through the least of evenly spaced values has its bottom."""
    at = int(np.argmin(left))
    if not 0 < at < left.size - 1:
        return float(tried[at])
    before, least, after = left[at - 1 : at + 2].tolist()
    bent = before - 2.0 * least + after
    off = 0.5 * (before - after) / bent if bent > 0.0 else 0.0
    return float(tried[at] + off * (tried[1] - tried[0]))
