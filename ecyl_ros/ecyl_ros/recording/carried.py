"""Whether a body's own speed says that its position, which stands still, must have moved.

A speed has an offset of its own, and integrated over a long rest that is a way, too. So the offset
is what the speed says beside the position wherever that runs on, and a way counts only beyond what
the offset's changes along the recording leave open.
"""

from __future__ import annotations

import numpy as np
from scipy.integrate import trapezoid  # NumPy has it under two names

from ..arrays import FloatArray, StampArray
from ..typical import typical_rms

_FEWEST = 20  # samples of speed over the stand
_PARTS = 8  # of what runs on, that the offset is told from
_SURE = 3.0  # standard deviations of the offset along the recording


def carried_way(
    values: FloatArray, begin: int, end: int, speed: FloatArray, stamps: StampArray
) -> float:
    """How far the speed carries a position that stands in [begin, end), for sure; 0 if nowhere."""
    seconds = (stamps - stamps[0]) / 1e9
    stands = np.zeros(values.size, dtype=bool)
    stands[begin:end] = True
    known = np.isfinite(values) & np.isfinite(speed[: values.size])
    rows = np.flatnonzero(known & stands)
    if rows.size < _FEWEST or not bool((speed[rows] != speed[rows[0]]).any()):
        return 0.0
    lasts = float(seconds[rows[-1]] - seconds[rows[0]])
    way = float(trapezoid(speed[rows], seconds[rows]))
    sides = (np.flatnonzero(known[:begin]), end + np.flatnonzero(known[end:]))
    offsets = [
        _ahead(values[part], speed[part], seconds[part])
        for side in sides
        for part in np.array_split(side, _PARTS)
        if part.size >= _FEWEST
    ]
    if not offsets:
        return abs(way)
    offset = float(np.median(offsets))
    spread = typical_rms(np.array(offsets) - offset)
    return max(abs(way - offset * lasts) - _SURE * spread * lasts, 0.0)


def _ahead(values: FloatArray, speed: FloatArray, seconds: FloatArray) -> float:
    """By how much a speed is above what its position makes of it, in the mean."""
    way = float(trapezoid(speed, seconds)) - float(values[-1] - values[0])
    return way / float(seconds[-1] - seconds[0])
