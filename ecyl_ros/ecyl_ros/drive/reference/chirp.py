"""`chirp`: a sine whose frequency runs linearly from `start` to `end`, then stays."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Chirp:
    """A linear chirp. amplitude, offset: m. start, end: Hz. sweep: s from start to end."""

    amplitude: float
    start: float
    end: float
    sweep: float
    offset: float = 0.0

    def sample(self, time_s: float) -> tuple[float, float]:
        """Position m and velocity m/s at `time_s`."""
        swept = min(time_s, self.sweep)
        slope = (self.end - self.start) / self.sweep
        cycles = self.start * swept + 0.5 * slope * swept * swept
        cycles += self.end * (time_s - swept)
        angle = 2.0 * math.pi * cycles
        rate = 2.0 * math.pi * (self.start + slope * swept)
        return (
            self.offset + self.amplitude * math.sin(angle),
            self.amplitude * rate * math.cos(angle),
        )
