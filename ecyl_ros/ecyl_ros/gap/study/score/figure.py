"""One figure of a study beside what is wanted of it, made of shares, quantiles and means."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from .targets import Wanted


@dataclass(frozen=True)
class Figure:
    """One figure of the study beside what is wanted of it.

    Attributes:
        name: what a table calls it.
        value: NaN where the study holds no such case.
        right, count: where the figure is a share of cases or causes, else None and the number
            that went into it.
        wanted: bound; None where nothing is. at_least: which way it bounds.
        unit: "%" for shares (kept as 0 to 1 here), "s", or "".
    """

    name: str
    value: float
    right: int | None
    count: int
    wanted: float | None
    at_least: bool = True
    unit: str = "%"

    @property
    def met(self) -> bool | None:
        """Whether the figure is what is wanted; None where there is nothing to compare."""
        if self.wanted is None or not math.isfinite(self.value):
            return None
        return self.value >= self.wanted if self.at_least else self.value <= self.wanted

    @property
    def interval(self) -> tuple[float, float] | None:
        """Wilson's 95 % interval of a share."""
        if self.right is None or not self.count:
            return None
        z, n, share = 1.96, self.count, self.right / self.count
        middle = (share + z * z / (2 * n)) / (1 + z * z / n)
        half = z / (1 + z * z / n) * math.sqrt(share * (1 - share) / n + z * z / (4 * n * n))
        return max(0.0, middle - half), min(1.0, middle + half)

    def as_json(self) -> dict[str, Any]:
        """Plain data; a value that is not there is null."""
        return {
            "name": self.name,
            "value": self.value if math.isfinite(self.value) else None,
            "right": self.right,
            "count": self.count,
            "ci95": list(self.interval) if self.interval else None,
            "wanted": self.wanted,
            "met": self.met,
        }


def counted(name: str, rights: Sequence[bool], wanted: Wanted = None) -> Figure:
    """The share of `rights` that are."""
    count, right = len(rights), sum(rights)
    return Figure(name, right / count if count else math.nan, right, count, wanted)


def quantile(
    name: str, values: Sequence[float], share: float, wanted: Wanted = None, **options: Any
) -> Figure:
    """The value that `share` of the values do not exceed: 0.5 for the median, 1 for the largest."""
    value = float(np.quantile(values, share)) if len(values) else math.nan
    return Figure(name, value, None, len(values), wanted, **options)


def mean(name: str, values: Sequence[float], wanted: Wanted = None, **options: Any) -> Figure:
    """Their mean."""
    value = float(np.mean(values)) if len(values) else math.nan
    return Figure(name, value, None, len(values), wanted, **options)
