"""The smallest fault of one shape that a recording shows, with its response."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ...arrays import FloatArray
from .limit import Limit
from .probes import Probe


@dataclass(frozen=True, eq=False)
class Seen:
    """A probe at the smallest size that is seen, and its response there, float64[1 or 2, m]."""

    probe: Probe
    size: float
    response: FloatArray

    @property
    def limit(self) -> Limit:
        """As it is said; without a size where none is seen."""
        one = self.probe
        size = self.size if math.isfinite(self.size) else None
        return Limit(
            one.effect, one.quantity.name, one.quantity.unit, size, one.neutral, one.side, one.at
        )
