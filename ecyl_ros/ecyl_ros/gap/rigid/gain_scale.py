"""How well the gain of the effort is known: all measured efforts share that uncertainty."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from ...effects.along import Along
from ...effects.term import Interval


class GainScale(NamedTuple):
    """factor: of all efforts over those recorded. unsure: its 95 % half width, as a share."""

    factor: float = 1.0
    unsure: float = 0.0

    @classmethod
    def of(cls, gain: Sequence[Interval] | None, along: Along) -> GainScale:
        """From the gain as it was found within its tolerance; exact where it has none."""
        if not gain or not along.units.own or not along.machine.gain:
            return cls()
        value, low, high = gain[0][2:]
        return cls(value / along.machine.gain, 0.5 * (high - low) / value)

    def scaled(self, span: Interval) -> Interval:
        """An effort, or what is counted by it, with its interval."""
        more = self.unsure * abs(span.value)
        low, high = (math.hypot(one - span.value, more) for one in (span.low, span.high))
        ends = (span.value, span.value - low, span.value + high)
        return Interval(span.name, span.unit, *(self.factor * one for one in ends))
