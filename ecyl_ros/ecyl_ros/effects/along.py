"""A measured motion of a rigid machine, as its effects see it."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.special import erf

from ..arrays import FloatArray
from ..drive.rigid.course import Course
from ..drive.rigid.machine import Machine
from ..drive.rigid.model import Model, Pair
from ..drive.rigid.units import Units

_SURE = 3.0  # standard deviations of the speed's noise, beyond which its sign is trusted
_SOFT = 1e-3  # of the largest speed: below it the sign of the speed is not trusted
_SOFTEST = 0.03  # of it: beyond, a level would look like a rise with speed
_STROKE = 0.1  # of the largest speed: what stays slower is no stroke
_AROUND, _NEARLY_ALL = 2.0 ** (1.0 / 3.0), 0.9  # times a frequency; of the power
# Below this no drive that is called rigid resonates: 2 Hz, as of a long arm, adds a third to the
# mass at half of it, and less the slower the motion is.
_SLOW_HZ = 1.0
UNMODELLED = 0.01  # share of the effort that no model of one inertia explains
# A sweep: parts of the time in which the motion is looked at, and that have to be left; of the
# median one's speed, what is rest; share of pairs, early and late, of which the late is slower (or
# faster) all the same; and by how much it is faster on the whole: friction that drifts changes a
# controlled motion by some percent.
_WINDOWS, _FEW_WINDOWS, _RESTS, _ALIKE, _FASTER = 20, 4, 0.1, 0.05, 1.25
_SAME = 0.01  # of the power of what depends on position: two forms that nothing tells apart


class Turn(NamedTuple):
    """What the orders of a wave over the position count.

    angle: float64[n]; of a straight output without a known lead it is the position, and what is
    found is a period in m. name, unit: of an order's parameter. rate: rad of `angle` per m or rad
    of the output.
    """

    angle: FloatArray
    name: str
    unit: str
    rate: float


class Along:
    """A motion and the nominal machine that made it; arrays are float64[n].

    Attributes:
        motion, machine, model, units: the model counts effort in `units`.
        top_speed: the largest but for 1 %. soft: speed below which its sign is not trusted.
        sign: of the speed, softened over what its noise leaves unsure. forwards, backwards: its
            positive and negative part. one: ones.
        both_ways: whether it moves forwards and backwards. turns: whether it goes round more than
            twice.
        side: what the friction and inertia of one inertia are called by: load, rotor.
        turn: see `Turn`.
    """

    def __init__(
        self,
        motion: Course,
        machine: Machine,
        model: Model,
        units: Units,
        nominal: Callable[[Along], FloatArray],
    ) -> None:
        """nominal: gives the effort that the file asks for with its effects, float64[n]."""
        self.motion, self.machine, self.model, self.units = motion, machine, model, units
        self._nominal = nominal
        usable, speed = motion.usable, motion.velocity
        top = float(np.quantile(np.abs(speed[usable]), 0.99))
        self.top_speed = top
        self.soft = max(_SOFT * top, min(_SURE * motion.speed_noise, _SOFTEST * top), 1e-12)
        # The mean sign of the true speed at a measured one; any wider, a friction that is the same
        # at all speeds would seem to be more near rest.
        self.sign: FloatArray = erf(_SURE * speed / (math.sqrt(2.0) * self.soft))
        self.forwards: FloatArray = np.maximum(self.sign, 0.0)
        self.backwards: FloatArray = np.minimum(self.sign, 0.0)
        both = min(float(np.mean(speed[usable] * way > self.soft)) for way in (1.0, -1.0))
        self.both_ways = both > 0.02
        self.one: FloatArray = np.ones_like(speed)
        self.side = "load" if machine.linear else "rotor"
        self.turns = float(np.ptp(motion.position[usable])) > 2.0 * math.tau

    @cached_property
    def strokes(self) -> tuple[int, int]:
        """How often it went forwards and backwards, rests and other recordings between or not."""
        speed = self.motion.velocity[self.motion.usable]
        ways = np.sign(speed[np.abs(speed) > _STROKE * self.top_speed])
        first = ways[np.flatnonzero(np.diff(ways, prepend=0.0))]
        return int(np.sum(first > 0.0)), int(np.sum(first < 0.0))

    @property
    def turn(self) -> Turn:
        position, lead = self.motion.raw_position, self.machine.lead
        if not self.machine.linear:
            return Turn(position, "periods_per_rev", "1", 1.0)
        if lead is not None:
            return Turn(position * (math.tau / lead), "periods_per_screw_rev", "1", math.tau / lead)
        return Turn(position, "period_m", "m", 1.0)

    @property
    def known_inertia(self) -> bool:
        """Whether the file, or an effect in it, tells the inertia."""
        return self.model.inertia is not None

    @property
    def known_gain(self) -> bool:
        """Whether effort as recorded can be told in N or N m."""
        return self.model.ratio > 0.0

    @property
    def rubs(self) -> bool:
        """Whether the nominal model has friction of some level."""
        return any(self.model.coulomb) or self.model.keys.coulomb > 0.0

    @cached_property
    def on_small_arc(self) -> bool:
        """Whether a rotary output stays where the weight of an arm gives what a spring does."""
        if self.machine.linear:
            return False
        angle = self.motion.position[self.motion.usable]
        off = angle - angle.mean()
        weight = np.stack([np.sin(angle), np.cos(angle), np.ones_like(angle)], axis=1)
        left = off - weight @ np.linalg.lstsq(weight, off, rcond=None)[0]
        return bool(np.sum(left**2) <= _SAME * np.sum(off**2))

    @cached_property
    def ramped(self) -> bool:
        """Whether the effort was commanded as a ramp: each way a line over time, as no machine's.

        What drifts with time would explain such a command, whatever the machine does.
        """
        motion = self.motion
        rows = motion.usable
        lines = np.stack([self.sign, self.sign * motion.own_s])[:, rows]
        effort = motion.effort[rows]
        left = effort - np.linalg.lstsq(lines.T, effort, rcond=None)[0] @ lines
        return bool(np.std(left) < UNMODELLED * np.std(effort))

    @cached_property
    def swept(self) -> bool:
        """Whether the motion is nowhere late what it was early, as in a sweep of the frequency.

        What depends on how fast it moves cannot be told from what drifts with time there.
        """
        motion = self.motion
        moved = motion.usable & (np.abs(motion.velocity) > self.soft)
        share = motion.own_s[moved] / max(float(motion.own_s.max()), 1e-12)
        window = np.minimum((share * _WINDOWS).astype(np.int64), _WINDOWS - 1)
        count = np.bincount(window, minlength=_WINDOWS)
        late = np.arange(_WINDOWS) >= _WINDOWS // 2
        for values in (motion.velocity, motion.acceleration):
            squares = np.bincount(window, values[moved] ** 2, _WINDOWS)
            rms = np.sqrt(squares / np.maximum(count, 1))
            kept = rms > _RESTS * float(np.median(rms[count > 0]))
            first, then = rms[kept & ~late], rms[kept & late]
            if min(first.size, then.size) < _FEW_WINDOWS:
                continue
            more = float(np.mean(then > first[:, None]))
            ratio = float(np.median(then) / np.median(first))
            if min(more, 1.0 - more) < _ALIKE and max(ratio, 1.0 / ratio) > _FASTER:
                return True
        return False

    @cached_property
    def one_frequency(self) -> bool:
        """Whether the effort accelerates within a third of an octave of one frequency, nearly all.

        At one frequency two masses and a stiffness move like one mass, of any size and sign; well
        below their resonance like their sum. By the cross-spectrum: noise of the acceleration is
        none of the effort's.
        """
        motion = self.motion
        both = np.where(motion.usable, np.stack([motion.acceleration, motion.effort]), 0.0)
        spectra = np.fft.rfft(both * np.hanning(motion.usable.size))
        power = np.abs(spectra[0] * spectra[1])
        power[0] = 0.0
        hertz = np.fft.rfftfreq(motion.usable.size, 1.0 / motion.rate_hz)
        top = hertz[int(np.argmax(power))]
        if top < _SLOW_HZ:
            return False
        near = (hertz >= top / _AROUND) & (hertz <= top * _AROUND)
        return bool(np.sum(power[near]) >= _NEARLY_ALL * np.sum(power))

    @property
    def unstated(self) -> frozenset[str]:
        """Frictions that every machine has and of which the file states none."""
        model = self.model
        stated = {
            "coulomb": self.rubs,
            "viscous": any(model.viscous) or model.keys.viscous > 0.0,
        }
        return frozenset(f"{self.side}_{form}_friction" for form in stated if not stated[form])

    def least_coulomb(self) -> Pair:
        """Least that friction of one level may be changed by, forwards and backwards."""
        return self._least(self.model.coulomb, self.model.keys.coulomb)

    def least_viscous(self) -> Pair:
        """The same of friction in proportion to speed."""
        return self._least(self.model.viscous, self.model.keys.viscous)

    def _least(self, nominal: Pair, stated: float) -> Pair:
        """All of it; without bound where the file states it and nothing tells the gain."""
        if stated > 0.0 and not self.known_gain:
            return -math.inf, -math.inf
        return -nominal[0], -nominal[1]

    def smooth(self) -> FloatArray:
        """What any machine asks for along the motion, up to its size, float64[5, n]."""
        motion = self.motion
        return np.stack(
            [motion.acceleration, motion.velocity, self.sign, self.one, motion.position]
        )

    def of_gain(self) -> tuple[FloatArray, float]:
        """The effort that grows with how the gain counts it, float64[n], and the inertia in it.

        For one of that: what keys and effects of the file ask of the drive in N or N m, less what
        was injected. Where the gain is unknown, effects are counted as the effort is and are not
        among it.
        """
        model, motion = self.model, self.motion
        if self.units.own:
            asked = (self._nominal(self) - motion.injected) / model.ratio
            return asked, (model.inertia or 0.0) / model.ratio
        keys = model.keys
        made: FloatArray = (
            keys.inertia * motion.acceleration
            + keys.viscous * motion.velocity
            + keys.coulomb * self.sign
            + keys.constant
            + keys.stiffness * motion.position
            - motion.injected
        )
        return made, keys.inertia
