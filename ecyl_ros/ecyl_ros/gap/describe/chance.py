"""Whether a law predicts by chance: each stretch of the recording from the others.

A law without a connection to what is missing changes each stretch as it happens. Of d stretches
that share the power of the gap alike, even the best size of such a change leaves a share of it that
is distributed as Beta((d - 1) / 2, 1 / 2): so is 1 - r^2 of two unconnected series of d values.
Within a stretch all may hang together, so that it counts as one value; where few stretches have
most of the gap, d is what their participation ratio says.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.stats import beta

from ..replay.replay import FloatArray

LEVEL = 0.01  # of a law by chance


def probability(before: FloatArray, after: FloatArray, floor: FloatArray, pieces: float) -> float:
    """Of leaving as little of the gap without a connection to it.

    Args:
        before, after: float64[stretches], sum of squares without the law, and with the law that the
            other stretches tell. floor: the same of what a perfect model leaves.
        pieces: independent pieces of evidence in all of them, which tell how well the floor is
            known.
    """
    surplus = np.maximum(before - floor, 0.0)
    whole = float(surplus.sum())
    if whole <= 0.0:
        return 1.0
    stretches = whole**2 / float(np.sum(surplus**2))
    unsure = float(floor.sum()) * math.sqrt(2.0 / max(pieces, 1.0))
    left = max(float(after.sum() - floor.sum()), unsure) / whole
    if stretches <= 1.0 or left >= 1.0:
        return 1.0
    return float(beta.cdf(left, 0.5 * (stretches - 1.0), 0.5))
