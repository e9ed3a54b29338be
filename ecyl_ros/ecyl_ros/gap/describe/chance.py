"""Whether a law predicts by chance: each stretch of the recording from the others.

A law without a connection to what is missing changes each stretch as it happens: the logarithm of
what is left with the law that the other stretches tell, over what is left without one, is as often
above zero as below, and on average above. Wilcoxon's signed-rank test over the stretches says how
far from that a law is. Ranks, because a law acts in some stretches far more than in others, and is
unknown in one that goes beyond all others: the fastest, the one with most current. No stretch
counts for more because much happened in it; within a stretch all may hang together.
"""

from __future__ import annotations

import numpy as np
from scipy.stats import wilcoxon

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
    larger = np.log(np.maximum(after[told] / before[told], _ROUNDED))
    if not np.any(larger != 0.0):
        return 1.0
    return min(1.0, sets * float(wilcoxon(larger, alternative="less").pvalue))
