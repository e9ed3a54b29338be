"""Rest: where the output stands, friction holds what it must, and a balance says nothing of it."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import binary_dilation, maximum_filter1d, minimum_filter1d

from ..diagnosis import BoolArray
from .motion import Motion
from .runs import runs_of

_SLOW = 0.02  # of the top speed: slower than that, for long and without getting anywhere, is rest
_PLACE = 2e-3  # of the travel: so far may it creep meanwhile (bristles give way)
_LEAST = 2.0  # periods of the bandwidth that it lasts, so that a mere reversal is none
_SMEARED = 0.75  # periods of the bandwidth over which the filter spreads what happens at rest


def at_rest(motion: Motion) -> BoolArray:
    """bool[n], True where the output stands, and as far around as the filter carries that."""
    usable = motion.usable
    speed = np.abs(motion.velocity)
    top = float(np.quantile(speed[usable], 0.99)) if usable.any() else 0.0
    travel = float(np.ptp(motion.position[usable])) if usable.any() else 0.0
    shortest = max(3, round(_LEAST * motion.rate_hz / motion.bandwidth_hz))
    around = maximum_filter1d(motion.position, shortest) - minimum_filter1d(
        motion.position, shortest
    )
    still = (speed < _SLOW * top) & (around <= _PLACE * travel)
    # As far as the windows reach that hold no motion; a mere reversal is shorter.
    slow = binary_dilation(still, np.ones(2 * (shortest // 2) + 1, dtype=bool))
    slow &= speed < _SLOW * top
    found = np.zeros_like(slow)
    for begin, end in runs_of(slow):
        found[begin:end] = end - begin >= shortest
    width = 2 * max(1, round(_SMEARED * motion.rate_hz / motion.bandwidth_hz)) + 1
    made: BoolArray = binary_dilation(found, np.ones(width, dtype=bool)) if found.any() else found
    return made
