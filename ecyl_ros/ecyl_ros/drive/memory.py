"""What a motion leaves behind, along a recording: the way since a reversal, and warmth."""

from __future__ import annotations

import math

import numpy as np
from scipy.signal import lfilter

from ..arrays import FloatArray


def since_reversal(position: FloatArray, speed: FloatArray) -> FloatArray:
    """Way since the speed last changed sign, signed: float64[n]."""
    sign = np.sign(speed)
    sign[sign == 0.0] = 1.0
    begins = np.flatnonzero(np.concatenate([[True], sign[1:] != sign[:-1]]))
    start = np.repeat(position[begins], np.diff(np.append(begins, len(position))))
    way: FloatArray = position - start
    return np.where(way * sign > 0.0, way, 0.0)


def warmed(values: FloatArray, step: float) -> FloatArray:
    """Squares behind a first-order low-pass that begins at 0, its steps in time constants."""
    kept = math.exp(-step)
    found: FloatArray = lfilter([1.0 - kept], [1.0, -kept], values**2)
    return found
