"""A position that is refreshed more slowly than it is logged: the rows where it is new.

Between them a logger repeats what it was told last. Nothing that moves does so, and a staircase
that is filtered or resampled is a motion that nobody made.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray

SLOW = 3  # rows from one new value to the next, at the least
_REGULAR = 0.8  # share of the values that last as long as usual, a row or a quarter more or less
FEWEST = 20  # new values that say how long is usual
_STEPS = 3.0  # of the smallest kind, that values leap by: else they wait for rounding
EQUAL = 1e-9  # of their range, that steps may differ by and be one


def fresh_rows(signals: Mapping[str, FloatArray]) -> NDArray[np.intp] | None:
    """Rows where the measured position of a table or topic is new; None where it always is.

    None, too, where a measured speed tells the motion in between, or a reference does that a loop
    is replayed with.
    """
    if any(name.startswith("reference_") for name in signals):
        return None
    places = [one for name, one in signals.items() if "_position_" in name]
    speeds = [one for name, one in signals.items() if "_velocity_" in name]
    if len(places) != 1 or any(_new(one) is None for one in speeds):
        return None
    return _new(places[0])


def _new(values: FloatArray) -> NDArray[np.intp] | None:
    """Rows where a signal is new, if it is held for as many rows each time; None where it is not.

    At rest, where it lasts longer, nothing tells which row is new.
    """
    known = np.flatnonzero(np.isfinite(values))
    steps = np.abs(np.diff(values[known]))
    changed = np.flatnonzero(steps > 0.0)
    if changed.size <= FEWEST:
        return None
    new: NDArray[np.intp] = known[changed + 1]
    leaps = steps[changed]
    smallest = float(leaps[leaps > EQUAL * np.ptp(values[known])].min(initial=np.inf))
    return new if held(np.diff(new), leaps, smallest, _REGULAR) else None


def held(lasts: NDArray[np.intp], leaps: FloatArray, smallest: float, share: float) -> bool:
    """Whether a signal is held, each value for as many rows.

    lasts: rows from one new value to the next. leaps: between them; smallest: of their kind. share:
    of the values that last as long as usual, at the least.
    """
    usual = float(np.median(lasts))
    regular = np.abs(lasts - usual) <= max(1.0, 0.25 * usual)
    # What is coarse (an encoder that turns evenly, a relay) waits as regularly for its next step.
    coarse = float(np.median(leaps)) < _STEPS * smallest
    return usual >= SLOW and not coarse and float(np.mean(regular)) >= share
