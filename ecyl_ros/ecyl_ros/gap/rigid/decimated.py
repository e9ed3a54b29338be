"""A filter without shift of phase, of which only every so many samples are wanted.

Hundreds of columns pass it in the search for a law, most of their samples are 0, and few of what
they become are compared. So each sample that is not 0 adds what the filter answers it with, at the
wanted samples alone.
"""

from __future__ import annotations

import numpy as np

from ...arrays import FloatArray
from ...drive.compiled import called, kernel


def decimated(columns: FloatArray, response: FloatArray, step: int) -> FloatArray:
    """Columns, float64[..., n], through a filter, at the samples step // 2 + i step.

    Beyond its ends a column goes on turned about them, as in `scipy.signal.sosfiltfilt`.

    Args:
        response: float64[2 m + 1], what the filter makes of one sample of 1.
        step: samples from one that is wanted to the next.

    Returns:
        float64[..., ceil((n - step // 2) / step)].
    """
    size = columns.shape[-1]
    each = np.ascontiguousarray(columns.reshape(-1, size), dtype=np.float64)
    made = np.zeros((len(each), -(-(size - step // 2) // step)))
    # The answer to a sample, from the first wanted one that it reaches: by how far it is off.
    taps = np.zeros((-(-len(response) // step), step))
    taps.reshape(-1)[: len(response)] = response
    _add(each, np.ascontiguousarray(taps.T), len(response) // 2, step, made)
    return made.reshape(*columns.shape[:-1], -1)


@kernel
def _answer(value, at, taps, side, step, row):
    """Add to the wanted samples `row` what a sample `at` of a column is answered with."""
    if value == 0.0:
        return
    from_first = at - step // 2 - side
    first = -((-from_first) // step)
    phase = first * step - from_first
    begin, end = max(first, 0), min(first + taps.shape[1], row.shape[0])
    if begin >= end:
        return
    # Without a sign an index needs no look whether it counts from the end.
    place, tap = np.uint64(begin), np.uint64(begin - first)
    for index in range(np.uint64(end - begin)):
        row[place + index] += value * taps[np.uint64(phase), tap + index]


@called
def _add(columns, taps, side, step, made):
    """See `decimated`.

    taps: float64[step, k], the response from each of its first samples on in strides of `step`.
    side: samples of it before its middle.
    """
    last = columns.shape[1] - 1
    for number in range(columns.shape[0]):
        column, row = columns[number], made[number]
        for beyond in range(1, side + 1):
            inside = min(beyond, last)
            _answer(2.0 * column[0] - column[inside], -beyond, taps, side, step, row)
            turned = 2.0 * column[last] - column[last - inside]
            _answer(turned, last + beyond, taps, side, step, row)
        for at in range(last + 1):
            _answer(column[at], at, taps, side, step, row)
