"""What those that play a machine along a measured motion, or weigh it, know of that motion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy

from ...arrays import BoolArray, FloatArray


@dataclass(frozen=True, eq=False, kw_only=True)
class Course:
    """A measured motion on an even grid; float64[n] in SI of the output, NaN where unknown.

    Attributes:
        time_s: from the first sample, at `rate_hz`.
        position, velocity, acceleration: low-passed without phase.
        raw_position: as recorded (bridged over short gaps).
        recorded_velocity, reference_position, reference_velocity: NaN where not recorded.
        effort: in the unit that the machine's effects are counted in; NaN where there is none.
        injected: of `effort`, what was put on the output from outside and is known in N or N m,
            whatever the drive's own gain; 0 where nothing was.
        usable: bool[n], where the motion is known.
        speed_noise: standard deviation of the noise of `velocity`.
    """

    time_s: FloatArray
    rate_hz: float
    position: FloatArray
    velocity: FloatArray
    acceleration: FloatArray
    raw_position: FloatArray
    recorded_velocity: FloatArray
    reference_position: FloatArray
    reference_velocity: FloatArray
    effort: FloatArray
    injected: FloatArray
    usable: BoolArray
    speed_noise: float

    @property
    def parts(self) -> tuple[slice, ...]:
        """The samples of each recording that the motion is of, in order."""
        return (slice(0, self.time_s.size),)

    def quiet(self, values: FloatArray) -> FloatArray:
        """float64[n] that follow the acceleration, as far as they say more than its noise.

        For what is not linear in them: the size of noise is not zero on average.
        """
        return values

    def derived(self, values: FloatArray, order: int, earlier_s: float) -> FloatArray:
        """A derivative of float64[n] over time by a cubic spline, so much before each sample."""
        course = scipy.interpolate.CubicSpline(np.arange(values.size) / self.rate_hz, values)
        made: FloatArray = course(np.clip(course.x - earlier_s, 0.0, course.x[-1]), order)
        return made

    @property
    def own_s(self) -> FloatArray:
        """float64[n], seconds from the first sample of the recording that a sample is of."""
        return self.time_s
