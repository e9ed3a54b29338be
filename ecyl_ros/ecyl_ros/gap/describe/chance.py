"""Whether a law predicts by chance: each stretch of the recording from the others.

The logarithm of what is left on a stretch with the law that the others tell, over what is left
without one, is positive on average for a law without a connection to what is missing: it changes
each stretch as it happens. A paired t-test over the stretches says how far from that a law is. No
stretch counts for more because much happened in it; within a stretch all may hang together.
"""

from __future__ import annotations

import numpy as np
from scipy.stats import t as student

from ..replay.replay import FloatArray

LEVEL = 0.01  # of a law by chance, over all sets of variables that were looked at
_ROUNDED = 1e-12  # of what is left without a law: less is rounding


def probability(before: FloatArray, after: FloatArray, sets: int) -> float:
    """Of leaving as little of the gap without a connection to it.

    Args:
        before, after: float64[stretches], mean squares without the law, and with the law that the
            other stretches tell; noise included.
        sets: how many sets of variables were looked at (Bonferroni).
    """
    told = before > 0.0
    smaller = -np.log(np.maximum(after[told] / before[told], _ROUNDED))
    count = len(smaller)
    if count < 2:
        return 1.0
    error = float(np.std(smaller, ddof=1)) / np.sqrt(count)
    if error <= 0.0:
        return 1.0
    return min(1.0, sets * float(student.sf(float(np.mean(smaller)) / error, count - 1)))
