"""What size of an effect is physically possible: beyond it, a limit is none."""

from __future__ import annotations

import dataclasses

from ...effects.catalogue import EFFECTS
from .limit import Limit

# Share of its nominal value by which a constant may be off. A motor of half or one and a half times
# its torque per ampere is another motor, or is counted in another convention.
_MOST_OFF = {"torque_constant_error": 0.5}


def possible(limit: Limit) -> Limit:
    """The limit, without a size where a fault of that size cannot be.

    An effect's own bounds hold (a ripple is a share, a delay less than the loop would stand), and
    those of constants whose nominal value says what it can be.
    """
    size = limit.smallest_seen
    if size is None:
        return limit
    value = limit.neutral + limit.side * size
    own = next((q for q in EFFECTS[limit.effect].parameters if q.name == limit.parameter), None)
    beyond = own is not None and not own.low <= value <= own.high
    off = _MOST_OFF.get(limit.effect)
    if beyond or (off is not None and size > off * abs(limit.neutral)):
        return dataclasses.replace(limit, smallest_seen=None)
    return limit
