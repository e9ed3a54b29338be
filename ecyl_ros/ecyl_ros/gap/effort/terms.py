"""Effects as columns of effort: what each asks of the drive along the measured motion.

    effort = M a + F_v v + F_c s(v) + c + k q + ...

with s(v) the sign of the speed, softened over what its noise leaves unsure. Parameters of an effect
follow from its coefficients; they are named as in the catalogue, with the unit of the output: `_nm`
where it turns, `_n` where it moves straight, `_a` or `_v` where the gain from the recorded signal
to effort is unknown.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from ..diagnosis import FloatArray
from .machine import Machine
from .motion import Motion

_SOFT = 1e-3  # of the largest speed: below it the sign of the speed is not trusted
_SPEEDS = 7  # Stribeck speeds tried

# A parameter: name, unit, value.
Parameters = tuple[tuple[str, str, float], ...]
_TOKENS = {"N": "n", "N m": "nm", "A": "a", "V": "v", "1": ""}


@dataclass(frozen=True)
class Units:
    """Units of effort and of what multiplies position, speed and acceleration."""

    effort: str
    linear: bool

    @property
    def _token(self) -> str:
        return _TOKENS[self.effort]

    def level(self, name: str) -> str:
        """Name of a parameter that is an effort."""
        return f"{name}_{self._token}".rstrip("_")

    def per_speed(self, name: str) -> str:
        """Name of a parameter that is an effort per speed."""
        return f"{name}_{self._token}_s_per_{'m' if self.linear else 'rad'}".replace("__", "_")

    def per_position(self, name: str) -> str:
        """Name of a parameter that is an effort per position."""
        return f"{name}_{self._token}_per_{'m' if self.linear else 'rad'}".replace("__", "_")

    @property
    def end(self) -> str:
        """Unit of position."""
        return "m" if self.linear else "rad"

    @property
    def speed_unit(self) -> str:
        """Of an effort per speed."""
        return f"{self.effort} s/{self.end}"

    @property
    def inertia(self) -> tuple[str, str]:
        """Name and unit of the inertia."""
        if self.effort == "N" and self.linear:
            return "mass_kg", "kg"
        if self.effort == "N m" and not self.linear:
            return "inertia_kg_m2", "kg m^2"
        name = f"inertia_{self._token}_s2_per_{self.end}".replace("__", "_")
        return name, f"{self.effort} s^2/{self.end}"


@dataclass(frozen=True, eq=False)
class Term:
    """A candidate.

    Attributes:
        effect: its name. key: of this very form of it (an order, a Stribeck speed).
        columns: float64[k, n] on the grid of the motion.
        parameters: from its coefficients.
        low: least value of each coefficient; -inf where it may have any.
        refines: effects that it contains.
        alternatives: effects that give the same columns in a rigid drive.
        fixed: parameters that were searched, not fitted. extent: time, turns or travel in m over
            which a rate was searched; 0 where it can only be a whole number.
    """

    effect: str
    key: str
    columns: FloatArray
    parameters: Callable[[FloatArray], Parameters]
    low: tuple[float, ...]
    refines: tuple[str, ...] = ()
    alternatives: tuple[str, ...] = ()
    fixed: Mapping[str, float] = field(default_factory=dict)
    extent: float = 0.0

    @property
    def size(self) -> int:
        """How many coefficients, found ones (an order, a speed) included."""
        return self.columns.shape[0] + len(self.fixed)


class Catalogue:
    """The effects that act on effort, along one motion."""

    def __init__(self, motion: Motion, machine: Machine) -> None:
        self.motion, self.machine = motion, machine
        self.units = Units(motion.effort_unit, machine.linear)
        usable = motion.usable
        speed = motion.velocity
        top = float(np.quantile(np.abs(speed[usable]), 0.99))
        noise = speed_noise(motion)
        self.top_speed = top
        self.soft = max(_SOFT * top, 3.0 * noise, 1e-12)
        self.sign = np.tanh(speed / self.soft)
        self.forwards = np.maximum(self.sign, 0.0)
        self.backwards = np.minimum(self.sign, 0.0)
        both = min(float(np.mean(speed[usable] * way > self.soft)) for way in (1.0, -1.0))
        self.both_ways = both > 0.02
        self.one = np.ones_like(speed)
        self.side = "load" if machine.linear else "rotor"

    # What the nominal model is made of.

    def nominal(self) -> FloatArray:
        """The effort that the drive file's own values ask for, float64[n]."""
        machine, motion = self.machine, self.motion
        made: FloatArray = (
            (machine.inertia or 0.0) * motion.acceleration
            + machine.viscous * motion.velocity
            + machine.coulomb * self.sign
            + machine.constant
            + machine.stiffness * motion.position
        )
        return made

    def unknown(self) -> list[Term]:
        """What the file leaves out and no balance can do without: the inertia."""
        return [] if self._known_inertia() else [self.inertia()]

    def _known_inertia(self) -> bool:
        known = self.motion.effort_unit in ("N", "N m")
        return self.machine.inertia is not None and known

    def inertia(self) -> Term:
        """The moving mass, true value."""
        nominal = (self.machine.inertia or 0.0) if self._known_inertia() else 0.0
        name, unit = self.units.inertia
        return Term(
            effect=f"{self.side}_inertia_error",
            key="inertia",
            columns=self.motion.acceleration[None],
            parameters=lambda c: ((name, unit, nominal + float(c[0])),),
            low=(-nominal,),
            alternatives=("torque_constant_error",) if self._gain_matters() else (),
        )

    def _gain_matters(self) -> bool:
        only_inertia = not (self.machine.viscous or self.machine.coulomb or self.machine.constant)
        return self.machine.gain not in (None, 1.0) and only_inertia and self._known_inertia()

    # Effects of which all columns are known.

    def simple(self) -> list[Term]:
        """Every effect whose columns follow from the motion alone."""
        found = [self.viscous(), self.constant(), self.spring()]
        if self._known_inertia():
            found.append(self.inertia())
        found.append(self.coulomb())
        if self.both_ways:
            found += [self.by_direction(), self.drift(), *self.stribeck()]
        if not self.machine.linear and not self.turns:
            found.append(self.gravity())
        return found

    @property
    def turns(self) -> bool:
        """Whether the output goes round more than twice."""
        return float(np.ptp(self.motion.position[self.motion.usable])) > 2.0 * math.tau

    def viscous(self) -> Term:
        """Friction in proportion to speed."""
        name, unit = self.units.per_speed("viscous"), self.units.speed_unit
        by_voltage = self.machine.actuation == "voltage"
        return Term(
            effect=f"{self.side}_viscous_friction",
            key="viscous",
            columns=self.motion.velocity[None],
            parameters=lambda c: ((name, unit, float(c[0])),),
            low=(-self.machine.viscous,),
            alternatives=("back_emf_error",) if by_voltage and self.machine.gain is None else (),
        )

    def coulomb(self) -> Term:
        """Friction of one level."""
        name, unit = self.units.level("coulomb"), self.units.effort
        return Term(
            effect=f"{self.side}_coulomb_friction",
            key="coulomb",
            columns=self.sign[None],
            parameters=lambda c: ((name, unit, float(c[0])),),
            low=(-self.machine.coulomb,),
            alternatives=() if self.both_ways else ("constant_load", "current_sensor_offset"),
        )

    def constant(self) -> Term:
        """A constant load; where the motion goes one way only, friction looks the same."""
        name, unit = self.units.level("force" if self.machine.linear else "torque"), self.units
        others: tuple[str, ...] = ("current_sensor_offset",)
        if not self.both_ways:
            others = (f"{self.side}_coulomb_friction", *others)
        return Term(
            effect="constant_load",
            key="constant",
            columns=self.one[None],
            parameters=lambda c: ((name, unit.effort, float(c[0])),),
            low=(-math.inf,),
            alternatives=others,
        )

    def spring(self) -> Term:
        """A force in proportion to position; its rest position goes into a constant."""
        name, unit = self.units.per_position("stiffness"), self.units
        middle = float(np.median(self.motion.position[self.motion.usable]))
        return Term(
            effect="spring_load",
            key="spring",
            columns=np.stack([self.motion.position - middle, self.one]),
            parameters=lambda c: ((name, f"{unit.effort}/{unit.end}", float(c[0])),),
            low=(-self.machine.stiffness, -math.inf),
            refines=("constant_load",),
        )

    def by_direction(self) -> Term:
        """Level and rise with speed, each by direction."""
        units, speed = self.units, self.motion.velocity
        names = (
            (units.level("coulomb_positive"), units.effort),
            (units.level("coulomb_negative"), units.effort),
            (units.per_speed("viscous_positive"), units.speed_unit),
            (units.per_speed("viscous_negative"), units.speed_unit),
        )
        return Term(
            effect="direction_dependent_friction",
            key="by_direction",
            columns=np.stack(
                [
                    self.forwards,
                    self.backwards,
                    np.maximum(speed, 0.0),
                    np.minimum(speed, 0.0),
                ]
            ),
            parameters=lambda c: tuple(
                (name, unit, float(value)) for (name, unit), value in zip(names, c, strict=True)
            ),
            low=(-self.machine.coulomb,) * 2 + (-self.machine.viscous,) * 2,
            refines=(f"{self.side}_coulomb_friction", f"{self.side}_viscous_friction"),
        )

    def stribeck(self) -> list[Term]:
        """More friction near rest than in motion, for several speeds at which it has fallen."""
        low, high = 5.0 * self.soft, 0.5 * self.top_speed
        if not high > 2.0 * low:
            return []
        return [self._stribeck(speed) for speed in np.geomspace(low, high, _SPEEDS).tolist()]

    def _stribeck(self, speed: float) -> Term:
        units = self.units
        surplus = self.sign * np.exp(-((self.motion.velocity / speed) ** 2))
        name = "stribeck_m_s" if self.machine.linear else "stribeck_rad_s"
        return Term(
            effect="stribeck_friction",
            key=f"stribeck {speed:.6g}",
            columns=np.stack([self.sign, surplus]),
            parameters=lambda c: (
                (units.level("coulomb"), units.effort, float(c[0])),
                (units.level("static"), units.effort, float(c[0] + c[1])),
                (name, f"{units.end}/s", speed),
            ),
            low=(-self.machine.coulomb, 0.0),
            refines=(f"{self.side}_coulomb_friction",),
            fixed={name: speed},
        )

    def drift(self) -> Term:
        """A friction level that changes evenly with time."""
        units = self.units
        time = self.motion.time_s

        def parameters(c: FloatArray) -> Parameters:
            rate = float(c[1] / c[0]) if c[0] else 0.0
            level = (units.level("coulomb"), units.effort, float(c[0]))
            return level, ("rate_per_s", "1/s", rate)

        return Term(
            effect="friction_drift",
            key="drift",
            columns=np.stack([self.sign, self.sign * time]),
            parameters=parameters,
            low=(-self.machine.coulomb, -math.inf),
            refines=(f"{self.side}_coulomb_friction",),
        )

    def gravity(self) -> Term:
        """The weight of an arm: a sine of the angle, once per turn."""
        units, angle = self.units, self.motion.position
        return Term(
            effect="gravity_on_arm",
            key="gravity",
            columns=np.stack([np.sin(angle), np.cos(angle)]),
            parameters=lambda c: (
                (units.level("amplitude"), units.effort, float(np.hypot(c[0], c[1]))),
            ),
            low=(-math.inf, -math.inf),
            refines=("constant_load", "spring_load"),
            alternatives=(),
        )

    # Effects whose columns need what the model already explains.

    def dependent(self, explained: FloatArray) -> list[Term]:
        """Effects in proportion to the effort explained so far, float64[n], or to its change."""
        found = [self.delay(explained)]
        if self.both_ways:
            found.append(self.load_friction())
        gain = self.machine.gain
        if gain not in (None, 1.0) and self._known_inertia():
            found.append(self.torque_constant(float(gain or 1.0)))
        return found

    def delay(self, explained: FloatArray) -> Term:
        """Effort ahead of the motion (a late actuator), or, negative, recorded behind it."""
        return Term(
            effect="actuation_delay",
            key="delay",
            columns=np.gradient(explained, 1.0 / self.motion.rate_hz)[None],
            parameters=lambda c: (("delay_s", "s", float(c[0])),),
            low=(0.0,),
            alternatives=("measurement_delay",),
        )

    def load_friction(self) -> Term:
        """Friction in proportion to the load carried: to what inertia and constant load ask."""
        carried = np.abs(
            (self.machine.inertia or 0.0) * self.motion.acceleration + self.machine.constant
        )
        if not self._known_inertia():
            carried = np.abs(self.motion.acceleration)
        name = self.units.inertia if not self._known_inertia() else ("coefficient", "1")
        return Term(
            effect="load_dependent_friction",
            key="load friction",
            columns=(self.sign * carried)[None],
            parameters=lambda c: ((name[0], name[1], float(c[0])),),
            low=(0.0,),
        )

    def torque_constant(self, gain: float) -> Term:
        """Another gain from the recorded signal to effort: the nominal effort, scaled."""
        name = "torque_constant_n_per_a" if self.machine.linear else "torque_constant_nm_per_a"
        unit = "N/A" if self.machine.linear else "N m/A"
        if self.machine.actuation == "voltage":
            name, unit = name.replace("_a", "_v"), unit.replace("A", "V")
        return Term(
            effect="torque_constant_error",
            key="gain",
            columns=self.nominal()[None],
            parameters=lambda c: ((name, unit, gain / (1.0 + float(c[0]))),),
            low=(-0.9,),
        )

    def jam(self, middle: float, width: float) -> Term:
        """Drag against the motion on one part of the travel."""
        units, end = self.units, self.units.end
        distance = np.abs(self.motion.position - middle)
        edge = 0.1 * width
        inside = 0.5 * (1.0 - np.tanh((distance - 0.5 * width) / edge))
        return Term(
            effect="local_jam",
            key=f"jam {middle:.6g} {width:.6g}",
            columns=(self.sign * inside)[None],
            parameters=lambda c: (
                (units.level("coulomb"), units.effort, float(c[0])),
                (f"position_{end}", end, middle),
                (f"width_{end}", end, width),
            ),
            low=(0.0,),
            fixed={f"position_{end}": middle, f"width_{end}": width},
        )

    # Periodic effects, of an order or a frequency that has to be found.

    @property
    def turn(self) -> tuple[FloatArray, str, str]:
        """Angle that orders count turns of, with name and unit of an order's parameter.

        Of a straight output without a known lead it is the position, and what is found is a period
        in m.
        """
        position = self.motion.raw_position
        if not self.machine.linear:
            return position, "periods_per_rev", "1"
        if self.machine.lead is not None:
            return position * (math.tau / self.machine.lead), "periods_per_screw_rev", "1"
        return position, "period_m", "m"

    def _extent(self, name: str, order: float) -> float:
        if name == "periods_per_rev" and order == round(order) and self.turns:
            return 0.0
        travel = float(np.ptp(self.turn[0][self.motion.usable]))
        return travel if name == "period_m" else travel / math.tau

    def cogging(self, order: float) -> Term:
        """A sine of the position."""
        angle, name, unit = self.turn
        shown = math.tau / order if name == "period_m" else order
        units = self.units
        return Term(
            effect="cogging_torque",
            key=f"cogging {order:.9g}",
            columns=np.stack([np.sin(order * angle), np.cos(order * angle)]),
            parameters=lambda c: (
                (units.level("amplitude"), units.effort, float(np.hypot(c[0], c[1]))),
                (name, unit, shown),
            ),
            low=(-math.inf, -math.inf),
            fixed={name: shown},
            extent=self._extent(name, order),
        )

    def ripple(self, order: float) -> Term:
        """A sine of the position times the effort."""
        angle, name, unit = self.turn
        shown = math.tau / order if name == "period_m" else order
        effort = self.motion.effort
        return Term(
            effect="torque_ripple",
            key=f"ripple {order:.9g}",
            columns=np.stack([effort * np.sin(order * angle), effort * np.cos(order * angle)]),
            parameters=lambda c: (
                ("fraction", "1", float(np.hypot(c[0], c[1]))),
                (name, unit, shown),
            ),
            low=(-math.inf, -math.inf),
            fixed={name: shown},
            extent=self._extent(name, order),
        )

    def disturbance(self, frequency_hz: float) -> Term:
        """A sine of time."""
        phase = math.tau * frequency_hz * self.motion.time_s
        units = self.units
        return Term(
            effect="periodic_disturbance",
            key=f"disturbance {frequency_hz:.9g}",
            columns=np.stack([np.sin(phase), np.cos(phase)]),
            parameters=lambda c: (
                (units.level("amplitude"), units.effort, float(np.hypot(c[0], c[1]))),
                ("frequency_hz", "Hz", frequency_hz),
            ),
            low=(-math.inf, -math.inf),
            fixed={"frequency_hz": frequency_hz},
            extent=float(np.ptp(self.motion.time_s[self.motion.usable])),
        )


def speed_noise(motion: Motion) -> float:
    """Standard deviation of the low-passed speed, from the position's noise.

    White noise of sigma, differentiated, up to the cutoff f_c: 2 pi sigma sqrt(2 f_c^3 / (3 f_s)).
    """
    cutoff = min(2.5 * motion.bandwidth_hz, 0.45 * motion.rate_hz)
    return math.tau * motion.position_noise * math.sqrt(2.0 * cutoff**3 / (3.0 * motion.rate_hz))
