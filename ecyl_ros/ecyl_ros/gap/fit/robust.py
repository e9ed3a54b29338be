"""Robust mean squares of gaps in noise floors: what every comparison of fits rests on.

Cauchy's: c^2 log(1 + (z / c)^2) in place of z^2. An impact of the flanks that comes a sample early
is a spike in speed and voltage, with its mirror image a sample later; squared, such spikes hide how
near a fit is and cut its valley into pieces. 0.85 for a perfect model.
"""

from __future__ import annotations

import math

import numpy as np

from ...arrays import BoolArray, FloatArray
from ...drive.compiled import called

_LARGE = 1e100  # a product of squares is taken its logarithm of before it overflows
_SMALL = 1e-9  # its logarithm differs from it by half of this share
_EVERY = np.ones(0, dtype=bool)  # for a mask: every column counts
LOSS_SCALE = 3.0  # in noise floors: beyond it a difference counts less than its square


def robust_squares(values: FloatArray, scale: float = LOSS_SCALE) -> FloatArray:
    """Cauchy's square of each difference in noise floors; beyond `scale` it counts less."""
    squares: FloatArray = scale**2 * np.log1p(_in_scales(values, scale))
    return squares


def _in_scales(values: FloatArray, scale: float) -> FloatArray:
    """Squares of values over a scale; without end where a fit is nowhere near."""
    with np.errstate(over="ignore"):
        squares: FloatArray = (values / scale) ** 2
    return squares


@called
def _sum_of_logarithms(values, counted, scale):
    """Sum of log(1 + (value / scale)^2) over the columns that are `counted`.

    values: float64[k, n]. counted: bool[n], or `_EVERY`. Few logarithms, of products: what is small
    beside 1 is rounded off in them, and is added up by itself.
    """
    total, product, per = 0.0, 1.0, 1.0 / (scale * scale)
    every = counted.size == 0
    for row in range(values.shape[0]):
        for column in range(values.shape[1]):
            if every or counted[column]:
                square = values[row, column] ** 2 * per
                if square < _SMALL:
                    total += square
                    continue
                product *= 1.0 + square
                if not product < _LARGE:
                    total += math.log(product)
                    product = 1.0
    return total + math.log(product)


def _mean(values: FloatArray, counted: BoolArray, scale: float, count: int) -> float:
    return scale**2 * _sum_of_logarithms(values, counted, scale) / count if count else math.nan


def robust_mean_square(values: FloatArray, scale: float = LOSS_SCALE) -> float:
    """Cauchy's mean square of differences in noise floors."""
    return _mean(values.reshape(1, -1), _EVERY, scale, values.size)


def robust_weights(values: FloatArray, scale: float = LOSS_SCALE) -> FloatArray:
    """What each square counts for where Cauchy's loss is brought down by weighted squares."""
    weights: FloatArray = 1.0 / (1.0 + _in_scales(values, scale))
    return weights


def per_square(evidence: float, weight: FloatArray, residual: FloatArray) -> float:
    """What a weighted square counts for, where all samples say no more than so many pieces of
    evidence; at a residual below the floor no more than at it."""
    return evidence / max(float(np.vdot(weight, residual**2)), float(residual.size))


def cost(gap: FloatArray, rows: BoolArray) -> float:
    """Robust mean square of a gap (signals, n) over its noise floor on the rows chosen."""
    return _mean(gap, rows, LOSS_SCALE, len(gap) * int(np.count_nonzero(rows)))


def misfit(cost: float) -> float:
    """Root of a mean square."""
    return math.sqrt(cost)
