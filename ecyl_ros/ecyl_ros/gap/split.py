"""Which stretches of a recording are fitted and which are held out for judging."""

from __future__ import annotations

import numpy as np

from .replay import BoolArray, FloatArray

STRETCH_S = 0.5
_HELD_OUT_EVERY = 3  # one stretch in so many is never fitted


def held_out(time_s: FloatArray) -> BoolArray:
    """bool[n], True on stretches that no parameter is fitted to.

    Stretches are contiguous and spread over the whole recording, so that every kind of motion in
    it is both fitted and judged.
    """
    length = min(STRETCH_S, float(time_s[-1]) / (4.0 * _HELD_OUT_EVERY))
    index = np.floor(time_s / max(length, 1e-9)).astype(np.int64)
    chosen: BoolArray = index % _HELD_OUT_EVERY == 1
    return chosen
