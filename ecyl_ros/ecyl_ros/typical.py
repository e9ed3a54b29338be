"""How large values typically are, whatever a few of them do."""

from __future__ import annotations

import numpy as np

from .arrays import FloatArray

_PER_MEDIAN = 1.4826  # RMS of a normal distribution about zero over the median of its size


def typical_rms(values: FloatArray) -> float:
    """RMS about zero of a normal distribution whose size has the same median; NaN is passed over.

    values: float64[...], one finite at the least.
    """
    size = np.abs(values).ravel()  # in place, a fifth of the time that NumPy's own median takes
    unknown = np.isnan(size)
    if unknown.any():
        size = size[~unknown]
    middle = size.size // 2
    size.partition(middle)
    median = float(size[middle])
    if size.size % 2 == 0:
        median = 0.5 * (median + float(size[:middle].max()))
    return _PER_MEDIAN * median
