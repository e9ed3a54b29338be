"""Rising and falling edges of a loop, from its torque alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...errors import InputError
from .loop import Loop

TURN = 0.3  # of the range: a lesser dip is no turning point. Half of it is the first loading
WHOLE = 0.8  # of the range: a shorter way is no edge (the first loading, a broken-off test)
SMOOTHED = 200  # the torque is median-filtered over a part in so many before its turns are sought


@dataclass(frozen=True)
class Edges:
    """Slices of the loop's readings, in the order of time."""

    rising: tuple[slice, ...]
    falling: tuple[slice, ...]


def split_edges(loop: Loop) -> Edges:
    """Find the whole edges of a loop.

    Raises:
        InputError: no whole edge in one of the directions.
    """
    from scipy.ndimage import median_filter
    from scipy.signal import find_peaks

    width = max(3, loop.torque_nm.size // SMOOTHED) | 1
    torque = median_filter(loop.torque_nm, size=width, mode="nearest")
    range_nm = float(np.ptp(torque))
    tops, _ = find_peaks(torque, prominence=TURN * range_nm)
    bottoms, _ = find_peaks(-torque, prominence=TURN * range_nm)
    turns = np.unique(np.concatenate(([0], tops, bottoms, [torque.size - 1])))
    edges: dict[bool, list[slice]] = {True: [], False: []}
    for first, last in zip(turns[:-1].tolist(), turns[1:].tolist(), strict=True):
        way = float(torque[last] - torque[first])
        if abs(way) >= WHOLE * range_nm:
            edges[way > 0.0].append(slice(first, last + 1))
    if not edges[True] or not edges[False]:
        missing = "rising" if not edges[True] else "falling"
        raise InputError(
            f"{loop.source}: no {missing} edge over {WHOLE:.0%} of the torque's range of "
            f"{range_nm:.4g} N m; expected a loop from end to end and back"
        )
    return Edges(tuple(edges[True]), tuple(edges[False]))
