"""By how much a difference raises the robust mean square, beside noise at its floor."""

from __future__ import annotations

import numpy as np

from ...arrays import FloatArray
from ..fit.robust import robust_squares

_NODES, _WEIGHTS = np.polynomial.hermite_e.hermegauss(41)
_SHARES = _WEIGHTS / _WEIGHTS.sum()
_AT = np.concatenate([[0.0], np.geomspace(0.05, 60.0, 240)])
_NOISE = float(_SHARES @ robust_squares(_NODES))
_RISE = np.array([float(_SHARES @ robust_squares(_NODES + one)) - _NOISE for one in _AT])
_SMALL = float(_RISE[1] / _AT[1] ** 2)


def rise(difference: FloatArray) -> FloatArray:
    """Expected rise of Cauchy's square by a difference in floors, beside white noise of 1."""
    size = np.abs(difference)
    near: FloatArray = np.interp(size, _AT, _RISE)
    return np.where(size > _AT[-1], robust_squares(difference) - _NOISE, near)


def weights(difference: FloatArray) -> FloatArray:
    """`rise` over the difference's square."""
    square = difference**2
    small = square < _AT[1] ** 2
    made: FloatArray = np.where(small, _SMALL, rise(difference) / np.where(small, 1.0, square))
    return made
