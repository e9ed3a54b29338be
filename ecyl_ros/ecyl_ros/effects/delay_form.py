"""How well a delay can be known at all."""

from __future__ import annotations

from ..drive.parameters import DriveParameters

# Share of a control tick, within which what is late is held, sampled and stepped otherwise from one
# drive, or simulator, to the next; by the sealed study.
_OF_TICK = 0.02


def delay_form(drive: DriveParameters) -> float:
    """Half width that the interval of a delay does not fall below, s."""
    return _OF_TICK / drive.controller.rate
