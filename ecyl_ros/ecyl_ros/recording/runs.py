"""Runs of rows that hold."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..arrays import BoolArray


def runs_of(mask: BoolArray) -> NDArray[np.int64]:
    """First row of each run of True and the row behind it, int64[runs, 2]."""
    edges = np.diff(np.concatenate([[0], mask, [0]]).astype(np.int8))
    return np.flatnonzero(edges).astype(np.int64).reshape(-1, 2)
