"""An effort that is refreshed more slowly than the motion is logged: the rows that are new.

Between them a logger repeats what it was told last, and a fit that compares an old effort with a
new motion finds whatever goes with the phase of a stroke.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..diagnosis import FloatArray

_SLOW = 3  # rows from one new value to the next, at the least
_REGULAR = 0.6  # share of the values that last as long as usual, a row or a quarter more or less
_OLD = 0.5  # share of the rows, while the position goes on, that repeat the one before
_FEWEST = 20  # new values that say how long is usual
_STEPS = 3.0  # of the smallest kind, that values leap by: else they wait for rounding, or a switch
_EQUAL = 1e-9  # of their range, that values may differ by and be one: of sums of 64 bits


def new_rows(effort: FloatArray, position: FloatArray) -> NDArray[np.int64] | None:
    """Rows of both, float64[n], where the effort is new; None where it is in nearly every row.

    The position has to go on between them: at rest an effort may well stay what it is.
    """
    known = np.flatnonzero(np.isfinite(effort) & np.isfinite(position))
    if known.size < _SLOW * _FEWEST:
        return None
    values, place = effort[known], position[known]
    same = np.diff(values) == 0.0
    # Between two stamps, where everything was put on even ones, lies a value that is neither.
    new = np.flatnonzero(same & ~np.concatenate([[False], same[:-1]]))
    if new.size < _FEWEST + 1 or same.all():
        return None
    begin, end = new[:-1], new[1:]
    moved = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(place)) > 0.0)])
    going = moved[end - 1] - moved[begin] >= 0.5 * (end - 1 - begin)
    lasts = (end - begin)[going]
    if lasts.size < _FEWEST:
        return None
    usual = float(np.median(lasts))
    regular = np.abs(lasts - usual) <= max(1.0, 0.25 * usual)
    jumps = np.abs(np.diff(values[new]))
    coarse = float(np.median(jumps)) < _STEPS * _smallest(values[new])
    repeats = np.concatenate([[0], np.cumsum(same)])
    old = float(np.sum((repeats[end] - repeats[begin])[going])) >= _OLD * float(lasts.sum())
    if usual < _SLOW or coarse or not old or float(np.mean(regular)) < _REGULAR:
        return None
    return known[new[1:]]  # how old the first one is nobody knows


def _smallest(values: FloatArray) -> float:
    """Least difference of values, float64[k], that are held; of a relay's two levels all of it."""
    apart = np.diff(np.unique(values))
    return float(apart[apart > _EQUAL * np.ptp(values)].min(initial=np.inf))
