"""What a filter leaves of a line over an angle: fast motion makes it a frequency that is cut."""

from __future__ import annotations

from dataclasses import dataclass, replace

from ..arrays import BoolArray, FloatArray


@dataclass(frozen=True)
class Passed:
    """What the filter of a signal leaves of a line whose frequency changes with the speed.

    speed: float64[n], by which the angle changes, rad/s. step_s: between two samples. response:
    float64[m], share of a sine that is left, evenly from 0 Hz to half the sampling rate; beyond
    that nothing is.
    """

    speed: FloatArray
    step_s: float
    response: FloatArray

    def at(self, rows: slice | BoolArray) -> Passed:
        """The same for some of the rows; `step_s` is still that of the filter."""
        return replace(self, speed=self.speed[rows])
