"""What a measured motion offers to those that play a machine along it, or weigh it."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]


class Course(Protocol):
    """A measured motion on an even grid; float64[n] in SI of the output, NaN where unknown."""

    @property
    def time_s(self) -> FloatArray:
        """From the first sample, s."""

    @property
    def rate_hz(self) -> float:
        """Of the grid."""

    @property
    def position(self) -> FloatArray:
        """Measured, low-passed without phase."""

    @property
    def raw_position(self) -> FloatArray:
        """Measured."""

    @property
    def velocity(self) -> FloatArray:
        """Measured, or from the position."""

    @property
    def speed_noise(self) -> float:
        """Standard deviation of the noise of `velocity`."""

    @property
    def acceleration(self) -> FloatArray:
        """From the velocity."""

    @property
    def recorded_velocity(self) -> FloatArray:
        """Measured; NaN throughout where no speed was recorded."""

    @property
    def reference_position(self) -> FloatArray:
        """Asked for."""

    @property
    def reference_velocity(self) -> FloatArray:
        """Asked for."""

    @property
    def effort(self) -> FloatArray:
        """Measured, in the unit that the machine's effects are counted in."""

    @property
    def usable(self) -> BoolArray:
        """bool[n], where the motion is known."""
