"""A multisine about the place where it begins, faded in from rest and out to rest.

Lines of equal amplitude with Schroeder's phases, as `multisine` has them, times a smooth step in
and out. Unlike moves, it turns without stopping, and moves fast and slow at once.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ...arrays import FloatArray
from ...errors import InputError
from ..compiled import called
from ..parameters import LimitParameters
from .multisine import Multisine

# Times a period of the highest line, for peaks: 0.1 % of them at the most is missed.
_LOOKED_AT = 64
_KNOTS = 16  # times a period: quintics through them are within a nanometre of a swing of metres
_SLACK = 2e-3  # share by which a swing may exceed a limit
_MOST_LINES, _MOST_KNOTS = 1000, 1_000_000


@called
def _swing(times, rates, phases, amplitude, length, fade, made):
    """Position and its first three derivatives at each time into `made`, float64[4, n].

    The fade is u^4 (35 - 84 u + 70 u^2 - 20 u^3): jerk goes on where it begins and ends.
    """
    for row in range(times.size):
        time = times[row]
        s0, s1, s2, s3 = 0.0, 0.0, 0.0, 0.0
        for line in range(rates.size):
            rate = rates[line]
            angle = rate * time + phases[line]
            sine, cosine = math.sin(angle), math.cos(angle)
            s0 += sine
            s1 += rate * cosine
            s2 -= rate * rate * sine
            s3 -= rate * rate * rate * cosine
        w0, w1, w2, w3 = 1.0, 0.0, 0.0, 0.0
        since, left = time, length - time
        u = min(since, left) / fade
        if u < 1.0:
            u = max(u, 0.0)
            slope = 1.0 / fade if since <= left else -1.0 / fade
            v = 1.0 - u
            w0 = u * u * u * u * (35.0 - 84.0 * u + 70.0 * u * u - 20.0 * u * u * u)
            w1 = 140.0 * u * u * u * v * v * v * slope
            w2 = 420.0 * u * u * v * v * (v - u) * slope**2
            w3 = 840.0 * u * v * (v * v - 3.0 * u * v + u * u) * slope**3
        made[0, row] = amplitude * (w0 * s0)
        made[1, row] = amplitude * (w1 * s0 + w0 * s1)
        made[2, row] = amplitude * (w2 * s0 + 2.0 * w1 * s1 + w0 * s2)
        made[3, row] = amplitude * (w3 * s0 + 3.0 * w2 * s1 + 3.0 * w1 * s2 + w0 * s3)


@dataclass(frozen=True)
class Swing:
    """Lines of `amplitude_m` each, from `start_hz` to `end_hz`, `base_hz` apart.

    length_s: of the swing; fade_s: of it in which it comes up, and again goes down; rest_s: after.
    """

    amplitude_m: float
    start_hz: float
    end_hz: float
    base_hz: float
    length_s: float
    fade_s: float
    rest_s: float = 0.0

    def begun_at(self, place_m: float) -> Swung:
        """The swing about a place."""
        return Swung(self, place_m)

    @cached_property
    def _peaks(self) -> tuple[float, float, float, float, float]:
        """Lowest and highest position, top speed, acceleration and jerk, of amplitude 1 m."""
        count = max(2, math.ceil(self.length_s * self.end_hz * _LOOKED_AT))
        unit = replace(self, amplitude_m=1.0).begun_at(0.0)
        place, *others = unit.derivatives(np.linspace(0.0, self.length_s, count))
        tops = [float(np.abs(one).max()) for one in others]
        return float(place.min()), float(place.max()), tops[0], tops[1], tops[2]

    def check(self, limits: LimitParameters, place_m: float, where: str) -> None:
        """Refuse a swing that asks a drive for more than its limits; InputError names the limit."""
        low, high, *tops = (self.amplitude_m * one for one in self._peaks)
        slack = _SLACK * (high - low)
        if place_m + low < limits.stroke_min - slack or place_m + high > limits.stroke_max + slack:
            raise InputError(
                f"{where}: amplitude_m = {self.amplitude_m:g} swings from {place_m + low:g} to "
                f"{place_m + high:g} m, expected within limits.stroke_min = {limits.stroke_min:g} "
                f"to limits.stroke_max = {limits.stroke_max:g} m of this drive"
            )
        for name, top in zip(("speed", "acceleration", "jerk"), tops, strict=True):
            most = getattr(limits, name)
            if top > most * (1.0 + _SLACK):
                raise InputError(
                    f"{where}: amplitude_m = {self.amplitude_m:g} comes to {name} {top:g}, "
                    f"expected at most limits.{name} = {most:g} of this drive: the motion was "
                    "planned for another"
                )

    def largest(self, limits: LimitParameters) -> float:
        """Amplitude about position 0 that just keeps the limits, m."""
        low, high, *tops = self._peaks
        room = [limits.stroke_max / high if high > 0.0 else math.inf]
        room.append(limits.stroke_min / low if low < 0.0 else math.inf)
        most = (limits.speed, limits.acceleration, limits.jerk)
        room += [one / top if top > 0.0 else math.inf for one, top in zip(most, tops, strict=True)]
        return max(0.0, min(room))

    def refused(self) -> str | None:
        """What of its fields does not go together, or None."""
        if not self.base_hz <= self.end_hz or not self.start_hz <= self.end_hz:
            return f"end_hz = {self.end_hz:g}, expected at least start_hz and base_hz"
        if self.end_hz / self.base_hz > _MOST_LINES:
            return (
                f"base_hz = {self.base_hz:g}, expected a thousandth of end_hz = {self.end_hz:g} "
                "at the least"
            )
        if not self._lines:
            return (
                f"base_hz = {self.base_hz:g}, expected a multiple of it between start_hz = "
                f"{self.start_hz:g} and end_hz = {self.end_hz:g}"
            )
        if self.length_s * self.end_hz * _KNOTS > _MOST_KNOTS:
            return f"length_s = {self.length_s:g}, expected fewer periods of end_hz"
        if not 0.0 < self.fade_s <= 0.5 * self.length_s:
            return f"fade_s = {self.fade_s:g}, expected more than 0 s and at most half of length_s"
        return None

    @cached_property
    def _lines(self) -> list[tuple[float, float]]:
        return Multisine(1.0, self.start_hz, self.end_hz, self.base_hz).lines

    @cached_property
    def rates_and_phases(self) -> FloatArray:
        """Of the lines, rad/s and rad, float64[2, lines]."""
        return np.array(self._lines).T.copy()


@dataclass(frozen=True, eq=False)
class Swung:
    """A swing about the place where it begins and ends."""

    swing: Swing
    end_m: float

    @property
    def length_s(self) -> float:
        """Without the rest."""
        return self.swing.length_s

    @property
    def rest_s(self) -> float:
        """After it."""
        return self.swing.rest_s

    def at(self, time_s: float) -> tuple[float, float, float]:
        """Position m, velocity m/s, acceleration m/s^2 at a time from its beginning to its end."""
        place, speed, faster, _ = self.derivatives(np.array([time_s]))[:, 0].tolist()
        return place, speed, faster

    def derivatives(self, times_s: FloatArray) -> FloatArray:
        """Position m and its first three derivatives at times float64[n] from 0 to the end.

        Returns float64[4, n].
        """
        swing = self.swing
        made = np.empty((4, len(times_s)))
        _swing(
            times_s, *swing.rates_and_phases, swing.amplitude_m, swing.length_s, swing.fade_s, made
        )
        made[0] += self.end_m
        return made

    def knots(self) -> list[float]:
        """Times between which quintics are the swing to within a nanometre, s."""
        count = max(2, math.ceil(self.length_s * self.swing.end_hz * _KNOTS))
        return [*np.linspace(0.0, self.length_s, count + 1).tolist()]
