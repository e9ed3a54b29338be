"""First-order low-pass filters as the control tick samples them."""

from __future__ import annotations

import math


def kept_share(time_constant_s: float, rate_hz: float) -> float:
    """Share of its last value that a low-pass keeps each tick, exp(-T / tau); 0 without one.

    What the filter gives is kept x (last) + (1 - kept) x (new): exact for a value that holds since
    the last tick, and the value itself as the time constant goes to zero.
    """
    if time_constant_s <= 0.0:
        return 0.0
    return math.exp(-1.0 / (time_constant_s * rate_hz))
