"""The inverse of a curvature whose coordinates are known by very different degrees."""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray

_NOTHING = 1e-12  # of the largest eigenvalue, each coordinate counted in its own size


def inverse_of(curvature: FloatArray) -> FloatArray:
    """Pseudo-inverse of a symmetric matrix, float64[k, k], that is nowhere negative.

    Each coordinate is counted in its own size first. A recording may tell a frequency 1e16 times as
    well as the scale of all torques, which the sheet alone tells: counted as they stand, the latter
    would be taken for a direction without curvature, and what is left open along it for certain.
    """
    size = np.sqrt(np.maximum(np.diag(curvature), 0.0))
    size[size == 0.0] = 1.0
    both = np.outer(size, size)
    found: FloatArray = np.linalg.pinv(curvature / both, rcond=_NOTHING, hermitian=True) / both
    return found
