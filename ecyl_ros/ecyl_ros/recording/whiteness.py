"""White noise of a few samples beside each other, whatever motion they show."""

from __future__ import annotations

import math

import numpy as np

from ..arrays import FloatArray
from ..typical import typical_rms

_WHITE = 0.6  # share of third differences that turn their sign; 0.77 where all is white noise


def white_noise(side: FloatArray) -> float:
    """Standard deviation of the white noise in some samples; 0 where they run smoothly.

    Of white noise three in four third differences have the other sign than the one before, of a
    smooth motion, however sharp its jerk, nearly none.
    """
    third = np.diff(side[np.isfinite(side)], 3)
    turns = third[1:] * third[:-1] < 0.0
    if third.size < 8 or not float(turns.mean()) > _WHITE:
        return 0.0
    return typical_rms(third) / math.sqrt(20.0)
