"""Plain data that JSON can hold."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any


def finite(data: Any) -> Any:
    """Plain data with None for numbers that JSON does not know."""
    if isinstance(data, dict):
        return {key: finite(value) for key, value in data.items()}
    if isinstance(data, str):
        return data
    if isinstance(data, float):
        return data if math.isfinite(data) else None
    return [finite(value) for value in data] if isinstance(data, Iterable) else data
