"""Blocks that turn without stopping: multisines as large as the limits allow.

Where moves come to rest at every turn, flanks and friction are passed through once a leg; lines of
several frequencies pass through them in ever other states, fast and slow at once.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from ..drive.parameters import LimitParameters
from ..drive.reference.swing import Swing

_HIGHEST_HZ = (1.0, 2.0, 4.0, 8.0)  # lines far above are beyond what position loops follow
_OCTAVES = 4  # from the lowest line to the highest
_LEAST_PERIODS = 1.0  # of the lowest line
_FADE = 0.125  # of its time, at each end
_LEAST_RATIO = 1.5  # of the highest line to the lowest
_ROOM = 0.999  # of the limits, so that rounding in a file does not go beyond them


@dataclass(frozen=True)
class Wave:
    """A share of the largest multisine from `low_hz` to `high_hz` that keeps a drive's limits."""

    share: float
    low_hz: float
    high_hz: float

    def legs(self, limits: LimitParameters, length_s: float) -> tuple[Swing, ...]:
        """One swing of `length_s`; none where the start lies at an end of the stroke."""
        low = max(self.low_hz, _LEAST_PERIODS / length_s)
        high = max(self.high_hz, _LEAST_RATIO * low)
        # The lowest line is one of the grid's, however short the time is.
        base = 0.5 * low if low * length_s >= 2.0 else low
        unit = Swing(1.0, low, high, base, length_s, _FADE * length_s)
        largest = _ROOM * self.share * unit.largest(limits)
        if not largest > 0.0:
            return ()
        return (Swing(largest, low, high, base, length_s, _FADE * length_s),)

    @property
    def point(self) -> tuple[float, ...]:
        """What a search may vary: logarithms of share and frequencies."""
        return math.log(self.share), math.log(self.low_hz), math.log(self.high_hz)

    def highest(self, limits: LimitParameters, reach: float) -> tuple[float, ...]:
        """The largest `point` within a drive's limits."""
        return 0.0, math.inf, math.inf

    def moved_to(self, point: Iterable[float]) -> Wave:
        """The wave at another point."""
        share, low, high = map(math.exp, point)
        return Wave(share, low, high)


def waves(length_s: float) -> list[Wave]:
    """Those to choose from, of `length_s` each."""
    least = _LEAST_PERIODS / length_s
    return [
        Wave(1.0, max(least, high / 2.0**_OCTAVES), high)
        for high in _HIGHEST_HZ
        if high >= _LEAST_RATIO * least
    ]
