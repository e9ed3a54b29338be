"""Where an effort jumps, as that of a relay or of a step test does.

What a jump sets off is faster than any band: it is fitted as far as it goes (see `mode`), and is no
evidence for one effect against another.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...arrays import BoolArray, FloatArray
from .motion import Motion, settling

_WITHIN = 2  # samples: a jump between two stamps, put on even ones, takes as many
_CALM = 0.25  # of a jump: what lies before and behind it changes by less, or it is no jump
_LEFT = 0.5  # of the usable rows that have to lie apart from jumps, or none is set aside


def jumping(effort: FloatArray, usable: BoolArray) -> BoolArray:
    """Steps from sample to sample, bool[n - 1], that are of a jump: within two samples by more
    than the effort's spread, and hardly before and behind."""
    inside = np.zeros(effort.size - 1, dtype=bool)
    spread = float(np.std(effort[usable])) if usable.any() else 0.0
    steps = np.abs(effort[_WITHIN:] - effort[:-_WITHIN])
    if spread == 0.0 or steps.size <= 2 * _WITHIN:
        return inside
    beside = np.full(steps.size, np.inf)
    beside[_WITHIN:-_WITHIN] = np.maximum(steps[: -2 * _WITHIN], steps[2 * _WITHIN :])
    far = (steps > spread) & (beside < _CALM * steps) & usable[_WITHIN:] & usable[:-_WITHIN]
    for later in range(_WITHIN):
        inside[later : later + far.size] |= far
    return inside


def calm(motion: Motion) -> BoolArray:
    """Compared rows, bool[m], that no jump reaches through the filter; all where few would be."""
    steps = jumping(motion.effort, motion.usable)
    rows: NDArray[np.int64] = motion.rows
    if not steps.any():
        return np.ones(rows.size, dtype=bool)
    reach = np.ones(2 * settling(motion.rate_hz, motion.bandwidth_hz) + 1)
    found: BoolArray = np.convolve(np.append(steps, False), reach, "same")[rows] < 0.5
    usable = motion.usable[rows]
    if np.sum(found & usable) < _LEFT * np.sum(usable):
        return np.ones(rows.size, dtype=bool)
    return found
