"""Whether a value of a file that someone wrote is a number to compute with."""

from __future__ import annotations

import math
from typing import Any


def is_finite(value: Any) -> bool:
    """A number, no truth value, neither NaN nor infinite, nor an integer beyond every float."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    try:
        return math.isfinite(value)
    except OverflowError:
        return False
