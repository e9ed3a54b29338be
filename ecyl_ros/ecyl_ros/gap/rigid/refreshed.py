"""An effort or a motion that is refreshed more slowly than it is logged: the rows that are new.

Between them a logger repeats what it was told last, and a fit that compares an old effort with a
new motion finds whatever goes with the phase of a stroke.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray
from ...recording.held import EQUAL, FEWEST, SLOW, fresh_rows, held
from ...recording.signals import FOREIGN_SIGNALS, SIGNALS, Recording

_REGULAR = 0.6  # share of the values that last as long as usual
_OLD = 0.5  # share of the rows, while the position goes on, that repeat the one before


def new_rows(effort: FloatArray, position: FloatArray) -> NDArray[np.int64] | None:
    """Rows of both, float64[n], where the effort is new; None where it is in nearly every row.

    The position has to go on between them: at rest an effort may well stay what it is.
    """
    known = np.flatnonzero(np.isfinite(effort) & np.isfinite(position))
    if known.size < SLOW * FEWEST:
        return None
    values, place = effort[known], position[known]
    same = np.diff(values) == 0.0
    # Between two stamps, where everything was put on even ones, lies a value that is neither.
    new = np.flatnonzero(same & ~np.concatenate([[False], same[:-1]]))
    if new.size < FEWEST + 1 or same.all():
        return None
    begin, end = new[:-1], new[1:]
    moved = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(place)) > 0.0)])
    going = moved[end - 1] - moved[begin] >= 0.5 * (end - 1 - begin)
    lasts = (end - begin)[going]
    if lasts.size < FEWEST:
        return None
    leaps = np.abs(np.diff(values[new]))
    repeats = np.concatenate([[0], np.cumsum(same)])
    old = float(np.sum((repeats[end] - repeats[begin])[going])) >= _OLD * float(lasts.sum())
    if not old or not held(lasts, leaps, _smallest(values[new]), _REGULAR):
        return None
    return known[new[1:]]  # how old the first one is nobody knows


def at_new_motion(recording: Recording) -> tuple[Recording, list[str]]:
    """The recording at the rows where its measured motion is new, and a note; whole, and none,
    where it is in every row.

    Of a table that holds a reference, too: without a loop to replay, none is needed between them.
    """
    names = [one for one in (*SIGNALS, *FOREIGN_SIGNALS) if recording.has(one)]
    measured = [one for one in names if not one.startswith("reference_")]
    rows = fresh_rows({one: recording.signal(one) for one in measured})
    if rows is None:
        return recording, []
    kept = recording.at(rows)
    return kept, [
        f"the position is new only every {1e3 / kept.rate_hz:.3g} ms, and old in the rows "
        "between: these are left out; log it as often as the reference"
    ]


def _smallest(values: FloatArray) -> float:
    """Least difference of values, float64[k], that are held; of a relay's two levels all of it."""
    apart = np.diff(np.unique(values))
    return float(apart[apart > EQUAL * np.ptp(values)].min(initial=np.inf))
