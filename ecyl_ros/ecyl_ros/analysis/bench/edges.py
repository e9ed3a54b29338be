"""Rising and falling edges of a loop, from its torque alone."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from ...arrays import FloatArray
from ...errors import InputError
from .loop import Loop

TURN = 0.3  # of the range: a lesser dip is no turning point. Half of it is the first loading
WHOLE = 0.8  # of the range: a shorter way is part of an edge (the first loading, a broken-off test)
PART = 0.1  # of the range: parts of edges lose this much after their turn, while friction turns
SMOOTHED = 200  # the torque is median-filtered over a part in so many before its turns are sought


@dataclass(frozen=True)
class Edges:
    """Slices of the loop's readings, in the order of time."""

    rising: tuple[slice, ...]
    falling: tuple[slice, ...]


def split_edges(loop: Loop) -> Edges:
    """Find the edges of a loop: whole ones, or where a direction has none, its parts.

    Raises:
        InputError: the edges of one direction do not cover the range of the torque.
    """
    from scipy.ndimage import median_filter
    from scipy.signal import find_peaks

    width = max(3, loop.torque_nm.size // SMOOTHED) | 1
    torque = median_filter(loop.torque_nm, size=width, mode="nearest")
    range_nm = float(np.ptp(torque))
    tops, _ = find_peaks(torque, prominence=TURN * range_nm)
    bottoms, _ = find_peaks(-torque, prominence=TURN * range_nm)
    turns = np.unique(np.concatenate(([0], tops, bottoms, [torque.size - 1])))
    ways: dict[bool, list[slice]] = {True: [], False: []}
    for first, last in itertools.pairwise(turns.tolist()):
        ways[bool(torque[last] > torque[first])].append(slice(first, last + 1))
    chosen = {}
    for rising, slices in ways.items():
        whole = [one for one in slices if np.ptp(torque[one]) >= WHOLE * range_nm]
        used = whole or [one for part in slices if (one := _turned(torque, part, range_nm))]
        if not used or np.ptp(np.concatenate([torque[one] for one in used])) < WHOLE * range_nm:
            raise InputError(
                f"{loop.source}: no {'rising' if rising else 'falling'} edges over "
                f"{100.0 * WHOLE:.0f} % of the torque's range of {range_nm:.4g} N m; expected a "
                "loop from end to end and back"
            )
        chosen[rising] = tuple(used)
    return Edges(chosen[True], chosen[False])


def _turned(torque: FloatArray, part: slice, range_nm: float) -> slice | None:
    """A part of an edge less what follows its turn; None where nothing is left."""
    away = np.flatnonzero(np.abs(torque[part] - torque[part.start]) >= PART * range_nm)
    if not away.size:
        return None
    first = part.start + int(away[0])
    return slice(first, part.stop) if part.stop - first > 2 else None
