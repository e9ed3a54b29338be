"""Runs put together: figures over several starts, elasticities, the forms the text is made of."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from .published import STIFFNESS_SHARES
from .readings import Reading
from .runs import CLEARANCE_SHARES, Ran

Key = tuple[str, str, float, int]


@dataclass(frozen=True)
class Spread:
    """Mean over the starts and their standard deviation (0 for one start)."""

    mean: float
    std: float


@dataclass(frozen=True)
class Results:
    """All runs by key, and what is asked of them."""

    readings: tuple[Reading, ...]
    runs: Mapping[Key, Ran]
    starts: int

    def reading(self, key: str) -> Reading:
        """A reading by its key."""
        return next(one for one in self.readings if one.key == key)

    def nominal(self, reading: str) -> Ran:
        """The run from rest with nothing changed."""
        return self.runs[(reading, "stiffness", 1.0, 0)]

    def at(self, reading: str, change: str, share: float, start: int = 0) -> Ran:
        """A run of a sweep."""
        return self.runs[(reading, "stiffness" if share == 1.0 else change, share, start)]

    def over_starts(
        self, reading: str, change: str, share: float, of: Callable[[Ran], float]
    ) -> Spread:
        """A figure over all starts; runs without it are left out."""
        values = [of(self.at(reading, change, share, start)) for start in range(self.starts)]
        known = [one for one in values if math.isfinite(one)]
        if not known:
            return Spread(math.nan, math.nan)
        return Spread(
            float(np.mean(known)), float(np.std(known, ddof=1)) if len(known) > 1 else 0.0
        )

    def elasticity(self, reading: str, change: str) -> float:
        """Percent of error per percent of the parameter: slope of the logarithms over the sweep."""
        shares = STIFFNESS_SHARES if change == "stiffness" else CLEARANCE_SHARES
        errors = [self.over_starts(reading, change, one, error_std).mean for one in shares]
        return float(np.polyfit(np.log(shares), np.log(errors), 1)[0])


def error_std(ran: Ran) -> float:
    """Standard deviation of the error, m."""
    return ran.error_std_m


def imf_std(number: int) -> Callable[[Ran], float]:
    """Standard deviation of mode `number` (0: IMF1), m."""
    return lambda ran: ran.imfs[number].std_m if len(ran.imfs) > number else math.nan
