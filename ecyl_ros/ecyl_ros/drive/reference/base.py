"""What every reference generator offers."""

from __future__ import annotations

from typing import Protocol


class Reference(Protocol):
    """Rod position and velocity wanted, as a function of time."""

    def sample(self, time_s: float) -> tuple[float, float]:
        """Return (position m, velocity m/s) wanted at `time_s` from the start of the run."""
        ...
