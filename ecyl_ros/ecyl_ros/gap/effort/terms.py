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

from ...drive.rigid.acting import Acting
from ...drive.rigid.machine import Machine
from ...drive.rigid.model import gain_ratio, model_of
from ...drive.rigid.units import Units
from ..diagnosis import FloatArray
from .motion import Motion

_SOFT = 1e-3  # of the largest speed: below it the sign of the speed is not trusted
_SOFTEST = 0.03  # of it: beyond, a level would look like a rise with speed
_SPEEDS = 7  # Stribeck speeds tried
_ROUNDS = 4  # a ripple's share of itself: a third of a third of a third is below any floor
_ONCE = 0.1  # an order this near to 1 is once per turn
# How rare an effect is: 0 of what most machines have, one more for every third of those before.
_RARE = {
    "constant_load": 1,
    "stribeck_friction": 1,
    "spring_load": 2,
    "periodic_disturbance": 2,
    "torque_ripple": 2,
    "load_dependent_friction": 2,
    "friction_drift": 2,
    "local_jam": 2,
    "current_sensor_offset": 2,
}

# A parameter: name, unit, value.
Parameters = tuple[tuple[str, str, float], ...]


@dataclass(frozen=True, eq=False)
class Term:
    """A candidate.

    Attributes:
        effect: its name. key: of this very form of it (an order, a Stribeck speed).
        columns: float64[k, n] on the grid of the motion.
        parameters: from its coefficients. values: the same as `acting` has them, phases and rest
            positions included; of inertia and gain what comes on top.
        low: least value of each coefficient; -inf where it may have any.
        refines: effects that it contains.
        alternatives: effects that give the same columns in a rigid drive.
        fixed: parameters that were searched, not fitted. extent: time, turns or travel in m over
            which a rate was searched; 0 where it can only be a whole number.
        rate: of a sine, per rad of the turn (per m, in Hz over time). phase: float64[n] of it.
    """

    effect: str
    key: str
    columns: FloatArray
    parameters: Callable[[FloatArray], Parameters]
    values: Callable[[FloatArray], dict[str, float]]
    low: tuple[float, ...]
    refines: tuple[str, ...] = ()
    alternatives: tuple[str, ...] = ()
    fixed: Mapping[str, float] = field(default_factory=dict)
    extent: float = 0.0
    rate: float = 0.0
    phase: FloatArray = field(default_factory=lambda: np.zeros(0))

    @property
    def size(self) -> int:
        """How many coefficients, found ones (an order, a speed) included."""
        return self.columns.shape[0] + len(self.fixed)


class Catalogue:
    """The effects that act on effort, along one motion."""

    def __init__(self, motion: Motion, machine: Machine) -> None:
        self.motion, self.machine = motion, machine
        self.units = Units(motion.effort_unit, machine.linear)
        self.model = model_of(machine, self.units.own)
        usable = motion.usable
        speed = motion.velocity
        top = float(np.quantile(np.abs(speed[usable]), 0.99))
        self.top_speed = top
        self.soft = max(_SOFT * top, min(3.0 * motion.speed_noise, _SOFTEST * top), 1e-12)
        self.sign = np.tanh(speed / self.soft)
        self.forwards = np.maximum(self.sign, 0.0)
        self.backwards = np.minimum(self.sign, 0.0)
        both = min(float(np.mean(speed[usable] * way > self.soft)) for way in (1.0, -1.0))
        self.both_ways = both > 0.02
        self.one = np.ones_like(speed)
        self.side = "load" if machine.linear else "rotor"

    # What the nominal model is made of.

    def nominal(self) -> FloatArray:
        """The effort that the drive file's own values and effects ask for, float64[n]."""
        model, motion = self.model, self.motion
        made: FloatArray = (
            (model.inertia or 0.0) * motion.acceleration
            + model.viscous[0] * np.maximum(motion.velocity, 0.0)
            + model.viscous[1] * np.minimum(motion.velocity, 0.0)
            + model.coulomb[0] * self.forwards
            + model.coulomb[1] * self.backwards
            + model.constant
            + model.stiffness * motion.position
        )
        shares = [one for one in model.shapes if one.name == "torque_ripple"]
        for one in model.shapes:
            if one not in shares:
                made += self._asked(one, made)
        bare = made
        for _ in range(_ROUNDS if shares else 0):  # a share of the whole effort, itself included
            made = bare + sum(self._asked(one, made) for one in shares)
        if model.delay_s:
            made = np.interp(motion.time_s + model.delay_s, motion.time_s, made)
        return made

    def _asked(self, one: Acting, effort: FloatArray) -> FloatArray:
        """What one effect of the file asks for beside an effort of float64[n]."""
        values = one.values
        match one.name:
            case "stribeck_friction":
                term = self._stribeck(values["stribeck"])
                parts = [values["coulomb"], values["static"] - values["coulomb"]]
            case "friction_drift":
                term = self.drift()
                parts = [values["coulomb"], values["coulomb"] * values["rate"]]
            case "load_dependent_friction":
                term, parts = self.load_friction("share" in values), list(values.values())
            case "local_jam":
                term = self.jam(values["position"], values["width"])
                parts = [values["coulomb"]]
            case "gravity_on_arm":
                term, parts = self.gravity(), _parts(values["amplitude"], values["phase"])
            case "cogging_torque":
                term = self.cogging(values["wave"] / self.turn_rate)
                parts = _parts(values["amplitude"], values["phase"])
            case "torque_ripple":
                term = self.ripple(values["wave"] / self.turn_rate, effort)
                parts = _parts(values["fraction"], values["phase"])
            case "periodic_disturbance":
                term = self.disturbance(values["frequency"])
                parts = _parts(values["amplitude"], values["phase"])
            case _:
                raise KeyError(one.name)
        made: FloatArray = np.array(parts) @ term.columns
        return made

    def _keys_effort(self) -> FloatArray:
        """The effort that the keys of the file ask for, by its own gain."""
        inertia, viscous, coulomb, constant, stiffness = self.model.keys
        motion = self.motion
        made: FloatArray = (
            inertia * motion.acceleration
            + viscous * motion.velocity
            + coulomb * self.sign
            + constant
            + stiffness * motion.position
        )
        return made

    def unknown(self) -> list[Term]:
        """What the file leaves out and no balance can do without: the inertia."""
        return [] if self._known_inertia() else [self.inertia()]

    def _known_inertia(self) -> bool:
        return self.model.inertia is not None

    def inertia(self) -> Term:
        """The moving mass, true value."""
        nominal = self.model.inertia or 0.0
        name, unit = self.units.inertia
        return Term(
            effect=f"{self.side}_inertia_error",
            key="inertia",
            columns=self.motion.acceleration[None],
            parameters=lambda c: ((name, unit, nominal + float(c[0])),),
            values=lambda c: {"inertia": float(c[0])},
            low=(-nominal,),
            alternatives=("torque_constant_error",) if self._gain_matters() else (),
        )

    def _gain_matters(self) -> bool:
        model = self.model
        only_inertia = not (any(model.viscous) or any(model.coulomb) or model.constant)
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
            values=lambda c: {"viscous": float(c[0])},
            low=(-min(self.model.viscous),),
            alternatives=("back_emf_error",) if by_voltage else (),
        )

    def coulomb(self) -> Term:
        """Friction of one level."""
        name, unit = self.units.level("coulomb"), self.units.effort
        return Term(
            effect=f"{self.side}_coulomb_friction",
            key="coulomb",
            columns=self.sign[None],
            parameters=lambda c: ((name, unit, float(c[0])),),
            values=lambda c: {"coulomb": float(c[0])},
            low=(-min(self.model.coulomb),),
            alternatives=() if self.both_ways else ("constant_load", "current_sensor_offset"),
        )

    def constant(self) -> Term:
        """A constant load; where the motion goes one way only, friction looks the same."""
        stem = "force" if self.machine.linear else "torque"
        name, unit = self.units.level(stem), self.units
        others: tuple[str, ...] = ("current_sensor_offset",)
        if not self.both_ways:
            others = (f"{self.side}_coulomb_friction", *others)
        return Term(
            effect="constant_load",
            key="constant",
            columns=self.one[None],
            parameters=lambda c: ((name, unit.effort, float(c[0])),),
            values=lambda c: {stem: float(c[0])},
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
            values=lambda c: {
                "stiffness": float(c[0]),
                "rest": middle - float(c[1] / c[0]) if c[0] else 0.0,
            },
            low=(-self.model.stiffness, -math.inf),
            refines=("constant_load",),
        )

    def by_direction(self) -> Term:
        """Level and rise with speed, each by direction."""
        units, speed = self.units, self.motion.velocity
        stems = ("coulomb_positive", "coulomb_negative", "viscous_positive", "viscous_negative")
        names = [(units.level(one), units.effort) for one in stems[:2]]
        names += [(units.per_speed(one), units.speed_unit) for one in stems[2:]]
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
            values=lambda c: dict(zip(stems, map(float, c), strict=True)),
            low=tuple(-one for one in (*self.model.coulomb, *self.model.viscous)),
            refines=(f"{self.side}_coulomb_friction", f"{self.side}_viscous_friction"),
            alternatives=("back_emf_error",) if self.machine.actuation == "voltage" else (),
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
            values=lambda c: {
                "coulomb": float(c[0]),
                "static": float(c[0] + c[1]),
                "stribeck": speed,
            },
            low=(-min(self.model.coulomb), 0.0),
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
            values=lambda c: {
                "coulomb": float(c[0]),
                "rate": float(c[1] / c[0]) if c[0] else 0.0,
            },
            low=(-min(self.model.coulomb), -math.inf),
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
            values=lambda c: _polar("amplitude", c),
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
            values=lambda c: {"delay": float(c[0])},
            low=(0.0,),
            alternatives=("measurement_delay",),
        )

    def load_friction(self, shared: bool | None = None) -> Term:
        """Friction in proportion to the load carried: to what inertia and constant load ask.

        shared: over the nominal load; by the acceleration alone where no inertia is known.
        """
        if shared is None:
            shared = self._known_inertia()
        inertia, _, _, constant, _ = self.model.keys
        inertia = inertia or (self.model.inertia or 0.0)
        carried = np.abs(inertia * self.motion.acceleration + constant)
        if not shared:
            carried = np.abs(self.motion.acceleration)
        name = ("coefficient", "1") if shared else self.units.inertia
        stem = "share" if shared else "inertia"
        return Term(
            effect="load_dependent_friction",
            key="load friction",
            columns=(self.sign * carried)[None],
            parameters=lambda c: ((name[0], name[1], float(c[0])),),
            values=lambda c: {stem: float(c[0])},
            low=(0.0,),
        )

    def torque_constant(self, gain: float) -> Term:
        """Another gain from the recorded signal to effort: what the file's keys ask, scaled."""
        ratio = gain_ratio(self.machine)
        name, unit = self.units.gain(self.machine.actuation == "voltage")
        return Term(
            effect="torque_constant_error",
            key="gain",
            columns=self._keys_effort()[None],
            parameters=lambda c: ((name, unit, gain / (ratio + float(c[0]))),),
            values=lambda c: {"ratio": float(c[0])},
            low=(-0.9 * ratio,),
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
            values=lambda c: {"coulomb": float(c[0]), "position": middle, "width": width},
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

    @property
    def turn_rate(self) -> float:
        """Rad of the angle that orders count, per m or rad of the output."""
        lead = self.machine.lead
        return math.tau / lead if self.machine.linear and lead is not None else 1.0

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
            values=lambda c: _polar("amplitude", c) | {"wave": order * self.turn_rate},
            low=(-math.inf, -math.inf),
            fixed={name: shown},
            alternatives=self._once(order, name),
            extent=self._extent(name, order),
            rate=order,
            phase=order * angle,
        )

    def _once(self, order: float, name: str) -> tuple[str, ...]:
        """What else makes one line per turn: a scale off its centre, a weight off the axis."""
        if name == "period_m" or abs(order - 1.0) > _ONCE:
            return ()
        screw = name == "periods_per_screw_rev"
        return ("encoder_eccentricity",) if screw else ("encoder_eccentricity", "gravity_on_arm")

    def ripple(self, order: float, effort: FloatArray) -> Term:
        """A sine of the position times `effort`, float64[n]: what is explained so far.

        Not what was measured, which holds what is to be explained.
        """
        angle, name, unit = self.turn
        shown = math.tau / order if name == "period_m" else order
        return Term(
            effect="torque_ripple",
            key=f"ripple {order:.9g}",
            columns=np.stack([effort * np.sin(order * angle), effort * np.cos(order * angle)]),
            parameters=lambda c: (
                ("fraction", "1", float(np.hypot(c[0], c[1]))),
                (name, unit, shown),
            ),
            values=lambda c: _polar("fraction", c) | {"wave": order * self.turn_rate},
            low=(-math.inf, -math.inf),
            fixed={name: shown},
            extent=self._extent(name, order),
            rate=order,
            phase=order * angle,
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
            values=lambda c: _polar("amplitude", c) | {"frequency": frequency_hz},
            low=(-math.inf, -math.inf),
            fixed={"frequency_hz": frequency_hz},
            extent=float(np.ptp(self.motion.time_s[self.motion.usable])),
            rate=frequency_hz,
            phase=phase,
        )


def rarity(effect: str) -> int:
    """How rare an effect is, 0 to 2: where two do nearly as well, what is common goes first."""
    return _RARE.get(effect, 0)


def _parts(amplitude: float, phase: float) -> list[float]:
    """Shares of sine and cosine in amplitude x sin(x + phase)."""
    return [amplitude * math.cos(phase), amplitude * math.sin(phase)]


def _polar(name: str, c: FloatArray) -> dict[str, float]:
    """The inverse of `_parts`."""
    return {name: float(np.hypot(c[0], c[1])), "phase": math.atan2(float(c[1]), float(c[0]))}
