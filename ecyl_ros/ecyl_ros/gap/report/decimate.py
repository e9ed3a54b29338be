"""Curves and clouds with no more points than a picture can show."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray


def columns_of(x: FloatArray, low: float, high: float, count: int) -> NDArray[np.int64]:
    """int64[n], the pixel column 0 to count - 1 of each x; -1 outside low..high or not finite."""
    known = np.isfinite(x) & (x >= low) & (x <= high)
    where = np.full(x.shape, -1, dtype=np.int64)
    width = (high - low) or 1.0
    where[known] = np.minimum(((x[known] - low) / width * count).astype(np.int64), count - 1)
    return where


def envelope(x: FloatArray, y: FloatArray, columns: int) -> tuple[FloatArray, FloatArray]:
    """The curve by the lowest and highest value of each of `columns` columns, in order of x.

    x: float64[n], not falling. y: float64[n]; a run of unknown values stays as one NaN, so that
    the curve is not drawn across it. Curves of up to two points a column come back whole.
    """
    n = x.size
    if n <= 2 * columns:
        return x, y
    where = columns_of(x, float(x[0]), float(x[-1]), columns)
    starts = np.flatnonzero(np.r_[True, where[1:] != where[:-1]])
    ends = np.r_[starts[1:], n]
    known = np.isfinite(y)
    picked: list[int] = []
    for start, end in zip(starts, ends, strict=True):
        rows = np.arange(start, end)
        good = rows[known[start:end]]
        chosen = set()
        if good.size:
            chosen |= {int(good[np.argmin(y[good])]), int(good[np.argmax(y[good])])}
        if good.size < rows.size:
            chosen.add(int(rows[~known[start:end]][0]))
        picked += sorted(chosen)
    return x[picked], y[picked]


def quantiles_over(
    x: FloatArray, y: FloatArray, bins: int, least: int = 8
) -> tuple[FloatArray, FloatArray]:
    """How y is spread over x: middles float64[k] and 5, 50, 95 % quantiles float64[3, k].

    Bins of equal width; those with fewer than `least` values are left out.
    """
    known = np.isfinite(x) & np.isfinite(y)
    empty = np.empty(0), np.empty((3, 0))
    if not known.any():
        return empty
    x, y = x[known], y[known]
    low, high = float(x.min()), float(x.max())
    if not high > low:
        return empty
    where = columns_of(x, low, high, bins)
    middles, spread = [], []
    for number in range(bins):
        values = y[where == number]
        if values.size >= least:
            middles.append(low + (number + 0.5) * (high - low) / bins)
            spread.append(np.quantile(values, (0.05, 0.5, 0.95)))
    if not middles:
        return empty
    return np.array(middles), np.array(spread).T
