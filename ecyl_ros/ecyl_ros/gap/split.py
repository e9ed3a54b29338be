"""Which stretches of a recording are fitted and which are held out for judging."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..arrays import BoolArray, FloatArray

STRETCH_S = 0.5
_HELD_OUT_EVERY = 3  # one stretch in so many is never fitted


# Tried in turn where a gap of a moment would lie on one side alone.
_SHORTER_S = (0.25, 0.1, 0.05, 0.02)
_LEAST, _MOST = 0.1, 0.8  # share of a gap that judging should see
_STANDS_OUT, _COUNTS = 3.0, 100.0  # noise floors: from which a difference counts, and up to which


def stretch_of(time_s: FloatArray) -> NDArray[np.int64]:
    """The number of the stretch of `STRETCH_S` that each instant lies in, int64[n]."""
    return np.floor(time_s / STRETCH_S).astype(np.int64)


def held_out(time_s: FloatArray, longest_s: float = STRETCH_S) -> BoolArray:
    """bool[n], True on stretches that no parameter is fitted to.

    Stretches are contiguous and spread over the whole recording, so that every kind of motion in
    it is both fitted and judged.
    """
    length = min(longest_s, float(time_s[-1]) / (4.0 * _HELD_OUT_EVERY))
    index = np.floor(time_s / max(length, 1e-9)).astype(np.int64)
    chosen: BoolArray = index % _HELD_OUT_EVERY == 1
    return chosen


def held_out_of(time_s: FloatArray, gap: FloatArray, usable: BoolArray) -> BoolArray:
    """`held_out` in stretches short enough that a gap of a moment is both fitted and judged.

    A limit may be reached once in a recording, for a tenth of a second. Stretches of half a second
    are kept where the gap (signals, n), in noise floors, lies on both sides anyway, and where no
    cut divides it.
    """
    over = np.clip(np.abs(gap), _STANDS_OUT, _COUNTS) ** 2 - _STANDS_OUT**2
    weight = np.where(usable, over.sum(axis=0), 0.0)
    whole = float(weight.sum())
    for length in (STRETCH_S, *_SHORTER_S):
        chosen = held_out(time_s, length)
        if _LEAST * whole <= float(weight[chosen].sum()) <= _MOST * whole:
            return chosen
    return held_out(time_s)
