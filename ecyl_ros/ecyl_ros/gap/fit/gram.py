"""Weighted inner products of a few very long rows."""

from __future__ import annotations

import numpy as np

from ...arrays import FloatArray

_BLOCK = 4096  # samples at a time: so many of some twenty rows stay in the cache


def weighted_products(
    rows: FloatArray, weights: FloatArray, values: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """(rows W rows', rows W values): float64[k, k], float64[k].

    Without BLAS: OpenBLAS 0.3.31 takes 300 times as long for 16 to 19 rows of this length as for 15
    or 20 on some processors, and begins threads that stand in the way of the replays beside them.

    rows: float64[k, m]. weights, values: float64[m].
    """
    gram = np.zeros((len(rows), len(rows)))
    along = np.zeros(len(rows))
    for first in range(0, rows.shape[1], _BLOCK):
        part = slice(first, first + _BLOCK)
        weighted = rows[:, part] * weights[part]
        gram += np.einsum("km,lm->kl", weighted, rows[:, part])
        along += np.einsum("km,m->k", weighted, values[part])
    return gram, along
