"""A trajectory of points with times, splined as ros2_control's joint_trajectory_controller does.

Between points with velocities and accelerations runs a quintic, with velocities alone a cubic. Of
positions alone the cubic spline is taken that leaves the present motion smoothly, has no step in
acceleration at any point, and ends at rest: straight lines would ask for steps in speed.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from ...arrays import FloatArray
from ..parameters import LimitParameters

State = tuple[float, float, float]  # position m, velocity m/s, acceleration m/s^2

# Points come with times in whole ns: what rounding makes of acceleration over a millisecond.
_ROUNDING = 1e-3
_REST = 1e-6  # m/s; the last point's velocity is one
_SAME_TIME_S = 1e-9


@dataclass(frozen=True)
class Point:
    """Where to be `time_s` after the start: m; velocity m/s and acceleration m/s^2 if given."""

    time_s: float
    position: float
    velocity: float | None = None
    acceleration: float | None = None


class Trajectory:
    """Polynomials from point to point, held at both ends. Times are the run's, s."""

    def __init__(self, times: FloatArray, coefficients: FloatArray) -> None:
        """times: float64[n + 1]. coefficients: float64[n, 6], rising powers of time in a piece."""
        self._times = times
        self._position = coefficients
        powers = np.arange(1, 6)
        self._velocity = coefficients[:, 1:] * powers
        self._acceleration = self._velocity[:, 1:] * powers[:-1]

    @property
    def end_s(self) -> float:
        """When the last point is reached."""
        return float(self._times[-1])

    def states(self, times_s: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Position, velocity and acceleration at each time, float64[n] each."""
        index = np.clip(np.searchsorted(self._times, times_s, "right") - 1, 0, len(self._times) - 2)
        inside = np.clip(times_s, self._times[0], self._times[-1]) - self._times[index]
        powers = inside[:, None] ** np.arange(6)
        return (
            (self._position[index] * powers).sum(axis=1),
            (self._velocity[index] * powers[:, :5]).sum(axis=1),
            (self._acceleration[index] * powers[:, :4]).sum(axis=1),
        )

    def at(self, time_s: float) -> State:
        """Position, velocity and acceleration; at rest once the last point is reached."""
        position, velocity, acceleration = self.states(np.array([time_s]))
        if time_s >= self.end_s:
            return float(position[0]), 0.0, 0.0
        return float(position[0]), float(velocity[0]), float(acceleration[0])

    def objection(self, limits: LimitParameters, period_s: float) -> str | None:
        """What a sample, one each `period_s`, or a point asks for beyond the limits; or None."""
        begin, end = self._times[0], self._times[-1]
        steps = np.arange(math.ceil((end - begin) / period_s)) * period_s
        times = np.union1d(begin + steps, self._times)
        position, velocity, acceleration = self.states(times)
        low, high = limits.stroke_min, limits.stroke_max
        slack = 1e-9 * max(1.0, high - low)
        asked = (
            ("m", position, low - slack, high + slack, f"{low:g} to {high:g} m, the stroke"),
            _most("m/s", velocity, limits.speed, 1e-6),
            _most("m/s^2", acceleration, limits.acceleration, _ROUNDING),
        )
        for unit, values, least, most, expected in asked:
            beyond = np.flatnonzero(~((values >= least) & (values <= most)))
            if beyond.size:
                worst = beyond[np.argmax(np.abs(values[beyond]))]
                return (
                    f"trajectory asks for {values[worst]:.4g} {unit} {times[worst] - begin:.4g} s "
                    f"after its start, expected {expected}"
                )
        return None


def _most(
    unit: str, values: FloatArray, most: float, slack: float
) -> tuple[str, FloatArray, float, float, str]:
    bound = most * (1.0 + slack)
    return unit, values, -bound, bound, f"at most {most:g} {unit}"


def made(points: Sequence[Point], start: State, now_s: float, begin_s: float) -> Trajectory:
    """The trajectory through `points` from a state at `now_s`; their times count from `begin_s`.

    Points whose time has come are left out, as the controller does.

    Raises:
        ValueError: why such points cannot be followed, with what was expected.
    """
    _check(points)
    ahead = [one for one in points if begin_s + one.time_s > now_s + _SAME_TIME_S]
    if not ahead:
        raise ValueError("trajectory is over already, expected points in time to come")
    times = np.array([now_s, *(begin_s + one.time_s for one in ahead)])
    places = np.array([start[0], *(one.position for one in ahead)])
    if ahead[0].velocity is None:
        # (The spline takes velocities at both ends; what lies between follows.)
        spline = scipy.interpolate.CubicSpline(times, places, bc_type=((1, start[1]), (1, 0.0)))
        speeds = spline(times, 1)
    else:
        speeds = np.array([start[1], *(one.velocity for one in ahead)], dtype=float)
    if ahead[0].acceleration is None:
        return Trajectory(times, _cubics(np.diff(times), places, speeds))
    bends = np.array([start[2], *(one.acceleration for one in ahead)], dtype=float)
    return Trajectory(times, _quintics(np.diff(times), places, speeds, bends))


def _check(points: Sequence[Point]) -> None:
    for number, one in enumerate(points, start=1):
        for name in ("time_s", "position", "velocity", "acceleration"):
            value = getattr(one, name)
            if value is not None and not math.isfinite(value):
                word = "time_from_start" if name == "time_s" else name
                raise ValueError(f"trajectory point {number}: {word} = {value} is not finite")
        for name in ("velocity", "acceleration"):
            if (getattr(one, name) is None) != (getattr(points[0], name) is None):
                raise ValueError(
                    f"trajectory point {number}: expected {name} at every point or at none"
                )
        if one.acceleration is not None and one.velocity is None:
            raise ValueError(f"trajectory point {number}: expected a velocity beside acceleration")
        least = 0.0 if number == 1 else points[number - 2].time_s
        if one.time_s < least or (number > 1 and one.time_s == least):
            raise ValueError(
                f"trajectory point {number}: time_from_start = {one.time_s:g} s, expected more "
                f"than {least:g} s"
            )
    last = points[-1].velocity
    if last is not None and abs(last) > _REST:
        raise ValueError(f"trajectory ends with {last:g} m/s, expected 0 m/s at its last point")


def _cubics(steps: FloatArray, places: FloatArray, speeds: FloatArray) -> FloatArray:
    rise = np.diff(places) / steps
    first, last = speeds[:-1], speeds[1:]
    nothing = np.zeros_like(steps)
    second = (3.0 * rise - 2.0 * first - last) / steps
    third = (first + last - 2.0 * rise) / steps**2
    return np.column_stack([places[:-1], first, second, third, nothing, nothing])


def _quintics(
    steps: FloatArray, places: FloatArray, speeds: FloatArray, bends: FloatArray
) -> FloatArray:
    first, bend = speeds[:-1], bends[:-1]
    # What position, velocity and acceleration at the end want beyond the start's parabola.
    a = np.diff(places) - first * steps - 0.5 * bend * steps**2
    b = (speeds[1:] - first - bend * steps) * steps
    c = (bends[1:] - bend) * steps**2
    return np.column_stack(
        [
            places[:-1],
            first,
            0.5 * bend,
            (10.0 * a - 4.0 * b + 0.5 * c) / steps**3,
            (-15.0 * a + 7.0 * b - c) / steps**4,
            (6.0 * a - 3.0 * b + 0.5 * c) / steps**5,
        ]
    )
