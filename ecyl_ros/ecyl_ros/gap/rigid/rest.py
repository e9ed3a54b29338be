"""Rest: where the output stands, friction holds what it must, and a balance says nothing of it."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import binary_dilation, maximum_filter1d, minimum_filter1d

from ...arrays import BoolArray, FloatArray
from ...effects.along import Along
from ...recording.runs import runs_of
from .motion import Motion

# Of the top speed of a recording: slower than that, for long and without getting anywhere, is rest.
_SLOW = 0.02
_PLACE = 2e-3  # of its travel: so far may it creep meanwhile (bristles give way)
_SLOWEST, _WAY = 0.1, 0.9  # ... and, in noise, at the most, of the speed below which so much of
# its way is gone: where an output hardly ever moves, its top speed by time is that of the noise
_NOISE = 3.0  # standard deviations of noise: what is beyond is motion
_LEAST = 2.0  # periods of the bandwidth that it lasts, so that a mere reversal is none
_REVERSING = 3.0  # times the speed over which the sign of the speed is softened
_ENOUGH = 0.5  # share of the samples that has to be in motion
_SMEARED = 0.75  # periods of its corner over which the filter spreads what happens at one sample


def at_rest(motion: Motion) -> BoolArray:
    """bool[n], True where the output stands, and as far around as the filter carries that."""
    usable = motion.usable
    speed = np.abs(motion.velocity)
    shortest = max(3, round(_LEAST * motion.rate_hz / motion.bandwidth_hz))
    around = maximum_filter1d(motion.position, shortest) - minimum_filter1d(
        motion.position, shortest
    )
    there, slowest = np.zeros(speed.size), np.zeros(speed.size)
    for part in motion.parts:  # what is slow beside another recording is motion all the same
        own = usable[part]
        if own.any():
            driven = speed[part][own]
            top = float(np.quantile(driven, 0.99))
            travel = float(np.ptp(motion.position[part][own]))
            there[part] = _PLACE * travel + 2.0 * _NOISE * motion.position_noise
            noisy = min(_NOISE * motion.speed_noise, _SLOWEST * _fast(driven))
            slowest[part] = max(_SLOW * top, noisy)
    still = (speed < slowest) & (around <= there)
    # As far as the windows reach that hold no motion; a mere reversal is shorter.
    slow = binary_dilation(still, np.ones(2 * (shortest // 2) + 1, dtype=bool))
    slow &= speed < slowest
    found = np.zeros_like(slow)
    for begin, end in runs_of(slow):
        found[begin:end] = end - begin >= shortest
    if not found.any():
        return found
    # A rest lasts: the weight at its lower corner carries it further than the band does.
    made: BoolArray = binary_dilation(
        found, np.ones(_smeared(motion, motion.corner_hz), dtype=bool)
    )
    return made


def _fast(speed: FloatArray) -> float:
    """The speed below which `_WAY` of the way is gone; speed: float64[n], at even instants."""
    by_speed = np.sort(speed)
    gone = np.cumsum(by_speed)
    return float(by_speed[np.searchsorted(gone, _WAY * gone[-1])])


def moving(rows: BoolArray, motion: Motion, along: Along) -> BoolArray:
    """`rows`, bool[m], less rests and reversals where the file holds friction.

    At rest friction holds whatever it must, up to its level: a balance cannot say whether it is as
    modelled.
    """
    if not along.rubs and not along.model.shapes:
        return rows
    kept: BoolArray = rows & ~reversing(motion, along)[motion.rows]
    return kept if kept.sum() > _ENOUGH * rows.sum() else rows


def reversing(motion: Motion, along: Along) -> BoolArray:
    """bool[n], where the sign of the speed is not sure, and as far as the filter carries that."""
    resting = np.abs(motion.velocity) < _REVERSING * along.soft
    resting[1:] |= np.signbit(motion.velocity[1:]) != np.signbit(motion.velocity[:-1])
    # A reversal is short, and leaves next to nothing below the band.
    found: BoolArray = maximum_filter1d(resting, _smeared(motion, motion.bandwidth_hz))
    return found


def _smeared(motion: Motion, corner_hz: float) -> int:
    """Samples over which a low-pass spreads what happens at one."""
    return 2 * max(1, round(_SMEARED * motion.rate_hz / corner_hz)) + 1
