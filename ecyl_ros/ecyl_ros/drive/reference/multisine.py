"""`multisine`: equally strong lines on a harmonic grid, with Schroeder's phases for a low crest."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property


@dataclass(frozen=True)
class Multisine:
    """Lines of equal amplitude at multiples of `base`, from `start` to `end`.

    amplitude: m, of each line. base, start, end: Hz. offset: m. Phases are -pi k (k - 1) / n
    (Schroeder 1970), shifted so that the motion starts at `offset`.
    """

    amplitude: float
    start: float
    end: float
    base: float
    offset: float = 0.0

    @cached_property
    def lines(self) -> list[tuple[float, float]]:
        """(rate rad/s, phase rad) of each."""
        first = max(1, math.ceil(self.start / self.base - 1e-9))
        last = math.floor(self.end / self.base + 1e-9)
        count = last - first + 1
        return [
            (2.0 * math.pi * self.base * (first + k), -math.pi * k * (k + 1) / count)
            for k in range(count)
        ]

    @cached_property
    def _start_position(self) -> float:
        return self.amplitude * sum(math.sin(phase) for _, phase in self.lines)

    def sample(self, time_s: float) -> tuple[float, float]:
        """Position m and velocity m/s at `time_s`."""
        position = velocity = 0.0
        for rate, phase in self.lines:
            position += math.sin(rate * time_s + phase)
            velocity += rate * math.cos(rate * time_s + phase)
        start = self.offset - self._start_position
        return start + self.amplitude * position, self.amplitude * velocity
