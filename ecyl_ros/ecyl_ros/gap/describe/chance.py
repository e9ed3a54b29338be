"""Whether a law predicts by chance: each part of the recording from stretches that it is not in.

A law without a connection to what is missing as often leaves more as it leaves less, and on average
it leaves more. Two tests see two kinds of law; either accepts, at half the level.

**By stretches**, Wilcoxon's signed-rank test on the logarithm of what is left over what is missing:
for laws that act in most of them. Ranks, because a law acts in some stretches far more than in
others, and is unknown in one that goes beyond all others: the fastest, the one with most current.

**By pieces**, for laws that act here and there. A law without a connection would predict no worse
at any other time: how it correlates with what is missing when it is shifted along the recording
says how many independent pieces the two have in common. The mean square is one over their number:
one where both wander as a whole, hundreds where both change fast. Each piece votes with the
logarithm of what is missing there over the noise; where nothing is missing no law can show. What is
missing is given, whatever the law: these weights are no choice made in its favour. The probability
of the votes is Chernoff's bound, which holds for few pieces as for many; where all votes are for
the law it is one half to the power of their number.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.optimize import minimize_scalar
from scipy.stats import wilcoxon

from ...arrays import FloatArray

LEVEL = 0.01  # of a law by chance, over all sets of variables that were looked at
_ROUNDED = 1e-12  # of what is left without a law: less is rounding
_TILT = (-6.0, 8.0)  # logarithms between which Chernoff's bound is least, weights of 0.002 to 30


def probability(
    missing: FloatArray, left: FloatArray, stretch: np.ndarray, noise: float, sets: int
) -> float:
    """Of leaving as little of what is missing without a connection to it.

    Args:
        missing: float64[signals, n], without the law. left: float64[signals, n], with the law that
            other stretches tell; noise included.
        stretch: int64[n], the stretch that each sample lies in.
        noise: mean square that a perfect model leaves.
        sets: how many sets of variables were looked at (Bonferroni).
    """
    either = 2.0 * min(by_stretches(missing, left, stretch), by_pieces(missing, left, noise))
    return min(1.0, sets * either)


def by_stretches(missing: FloatArray, left: FloatArray, stretch: np.ndarray) -> float:
    """The probability of what is left of the stretches; arguments as above."""
    number = np.unique(stretch, return_inverse=True)[1]
    before, after = (np.bincount(number, weights=np.sum(one**2, axis=0)) for one in (missing, left))
    told = before > 0.0
    larger = np.log(np.maximum(after[told] / before[told], _ROUNDED))
    if not np.any(larger != 0.0):
        return 1.0
    return float(wilcoxon(larger, alternative="less").pvalue)


def by_pieces(missing: FloatArray, left: FloatArray, noise: float) -> float:
    """The probability of what is left of the pieces; arguments as above."""
    edges = np.linspace(0.0, missing.shape[1], pieces(missing, missing - left) + 1).astype(np.int64)
    before, after = (
        np.add.reduceat(np.mean(one**2, axis=0), edges[:-1]) / np.diff(edges)
        for one in (missing, left)
    )
    return _of_votes(np.log(np.maximum(before / noise, 1.0)), after < before)


def pieces(missing: FloatArray, law: FloatArray) -> int:
    """How many independent pieces what is missing and a law have in common, one at the least.

    missing, law: float64[signals, n].
    """
    count = missing.shape[1]
    energy = float(np.sum(missing**2)) * float(np.sum(law**2))
    if not energy > 0.0:
        return 1
    first, second = (np.fft.rfft(one, 2 * count) for one in (missing, law))
    shifted = np.fft.irfft(np.sum(first * np.conj(second), axis=0), 2 * count)
    return max(1, min(count, int(count * energy / float(np.sum(shifted**2)))))


def _of_votes(weight: FloatArray, better: np.ndarray) -> float:
    """The probability of as many votes where each is as likely for the law as against it."""
    votes = float(np.sum(np.where(better, weight, -weight)))
    if not votes > 0.0:
        return 1.0
    told = weight[weight > 0.0]

    def bound(logarithm: float) -> float:
        by = math.exp(logarithm)
        return float(np.sum(np.logaddexp(by * told, -by * told) - math.log(2.0))) - by * votes

    return min(1.0, math.exp(minimize_scalar(bound, bounds=_TILT, method="bounded").fun))
