"""`sine`: a harmonic motion, the paper's excitation (section 4.1)."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Sine:
    """offset + amplitude sin(2 pi frequency t + phase).

    amplitude: m. frequency: Hz. phase: rad. offset: m.
    """

    amplitude: float
    frequency: float
    phase: float = 0.0
    offset: float = 0.0

    def sample(self, time_s: float) -> tuple[float, float]:
        """Position m and velocity m/s at `time_s`."""
        rate = 2.0 * math.pi * self.frequency
        angle = rate * time_s + self.phase
        return (
            self.offset + self.amplitude * math.sin(angle),
            self.amplitude * rate * math.cos(angle),
        )
