"""Effects in the shapes and sizes that their visibility is asked for, from the motion alone."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ...drive.parameters import DriveParameters
from ...drive.tolerances import constants_of, half_widths
from ...effects.catalogue import CATALOGUE
from ...effects.effect import Quantity
from ..replay.replay import Constants, Effects, Replay

Values = dict[str, float]

# Orders and frequencies at which the size of what repeats is stated: slots and pole pairs of usual
# motors, the first orders of a screw, and a low, a middle and a high frequency.
_ORDERS = {
    "cogging_torque": ("periods_per_rev", (6.0, 12.0, 24.0)),
    "torque_ripple": ("periods_per_rev", (6.0, 12.0, 24.0)),
    "transmission_error": ("periods_per_screw_rev", (1.0, 2.0)),
    "periodic_disturbance": ("frequency_hz", (2.0, 8.0, 25.0)),
}
_SOFTER = ("stiffness_error",)  # faults that make their constant less
_OFF = 3.0  # tolerances that a first look takes a constant off by
_SETTING = 1e-3  # share of it that a first look takes a setting off by
_PART = 1e-3  # share of a peak that a first look takes


@dataclass(frozen=True)
class Scale:
    """Peaks of what the drive does on a motion: N m, A, V, rad/s at the rotor, m at the rod."""

    torque: float
    current: float
    voltage: float
    speed: float
    travel: float
    middle: float
    rod_per_rotor: float
    tick_s: float

    @classmethod
    def of(cls, replay: Replay, effects: Effects, constants: Constants) -> Scale:
        """Of a drive, as a fit has found it, on a recording's reference."""
        drive = replay.drive
        simulated = replay.simulate(effects, constants)
        shown = dict(zip((one.name for one in replay.signals), simulated, strict=True))

        def peak(name: str) -> float:
            values = shown.get(name)
            return 0.0 if values is None else float(np.nanmax(np.abs(values)))

        reference = replay.reference_m
        ratio = drive.transmission.rod_per_rotor
        current = peak("current_q") or 1.0
        return cls(
            torque=drive.motor.torque_constant * current,
            current=current,
            voltage=peak("voltage_q") or drive.motor.resistance * current,
            speed=peak("rotor_velocity")
            or float(np.max(np.abs(np.gradient(reference, replay.time_s)))) / ratio
            or 1.0,
            travel=float(np.ptp(reference)) or 1e-6,
            middle=float(np.median(reference)),
            rod_per_rotor=ratio,
            tick_s=1.0 / drive.controller.rate,
        )

    def first(self, unit: str) -> float:
        """A size to look at first of what is counted in a unit."""
        force = self.torque / self.rod_per_rotor
        sizes = {
            "N m": _PART * self.torque,
            "N m s/rad": _PART * self.torque / self.speed,
            "N": _PART * force,
            "N/m": 10.0 * _PART * force / self.travel,
            "A": _PART * self.current,
            "V": _PART * self.voltage,
            "s": 0.1 * self.tick_s,
            "rad": 1e-4,
        }
        return sizes.get(unit, _PART)


@dataclass(frozen=True)
class Probe:
    """One effect in one shape.

    Attributes:
        effect: its name. quantity: its size. neutral, side: see `Limit`. first: size to look at
            first. made: the parameters at a size. turned: the same a quarter of a period later, of
            what repeats. at: what else describes it. caps: whether it acts from some value on,
            and does nothing short of that.
    """

    effect: str
    quantity: Quantity
    neutral: float
    side: int
    first: float
    made: Callable[[float], Values]
    turned: Callable[[float], Values] | None = None
    at: Mapping[str, float] = field(default_factory=dict)
    caps: bool = False

    @property
    def largest(self) -> float:
        """Size that is possible at most."""
        if self.side < 0:
            return 0.999 * abs(self.neutral - self.quantity.low)
        return self.quantity.high - self.neutral


def probes(name: str, drive: DriveParameters, scale: Scale) -> list[Probe]:
    """An effect in the shapes that its size is stated for; none where it has no one size."""
    effect = CATALOGUE[name]
    size = effect.parameters[0]
    tops = {"voltage_limit": scale.voltage, "current_limit": scale.current}
    if name in tops:
        return [_below(name, size, min(tops[name], size.high))]
    if name == "stiffness_hardening":
        torque = 0.2 * scale.torque
        return [_below(name, size, 1.0, {"torque_nm": torque})]
    neutral = effect.neutral(drive)
    side = -1 if name in _SOFTER else 1
    first = _first(name, drive, neutral) or scale.first(size.unit)
    shapes: Sequence[Values] = ({},)
    if name in _ORDERS:
        key, orders = _ORDERS[name]
        shapes = [{key: one} for one in orders]
    elif name == "stribeck_friction":
        shapes = [{"stribeck_rad_s": 0.05 * scale.speed}]
    elif name == "friction_drift":
        shapes = [{"rate_per_s": 0.05}]
    elif name == "local_jam":
        width = 0.05 * scale.travel
        shapes = [{"position_m": scale.middle, "width_m": width, "edge_m": 0.1 * width}]
    elif any(one.default is None for one in effect.parameters[1:]) and effect.sized is None:
        return []
    return [_probe(name, size, neutral, side, first, shape) for shape in shapes]


def _first(name: str, drive: DriveParameters, neutral: float) -> float:
    """Size of a constant's effect to look at first; 0 where the model has none of it."""
    key = CATALOGUE[name].constant
    wide = half_widths(constants_of(drive), drive.tolerances).get(key or "", 0.0)
    return _OFF * wide or _SETTING * abs(neutral)


# What grows with the size in another share than 1, by effect.
_WITH_SIZE = {
    "stribeck_friction": {"static_nm": 1.5},
    "direction_dependent_friction": {"coulomb_negative_nm": 0.0},
}


def _probe(
    name: str, size: Quantity, neutral: float, side: int, first: float, shape: Values
) -> Probe:
    effect = CATALOGUE[name]
    with_size = _WITH_SIZE.get(name, {})

    def made(deviation: float, phase: float = 0.0) -> Values:
        values = {size.name: neutral + side * deviation, **shape}
        values |= {key: share * deviation for key, share in with_size.items()}
        if repeats:
            values["phase_rad"] = phase
        return effect.complete(values)

    repeats = any(one.name == "phase_rad" for one in effect.parameters)
    turned = (lambda deviation: made(deviation, 0.5 * math.pi)) if repeats else None
    at = {**shape, **{key: share for key, share in with_size.items() if share}}
    at = {key: value for key, value in at.items() if key not in with_size and key != "edge_m"}
    return Probe(name, size, neutral, side, first, made, turned, at)


def _below(name: str, size: Quantity, top: float, shape: Values | None = None) -> Probe:
    """Of a limit: it is seen from somewhere below what the motion asks for."""
    others = shape or {}

    def made(deviation: float) -> Values:
        return CATALOGUE[name].complete({size.name: max(top - deviation, size.low), **others})

    return Probe(name, size, top, -1, 0.05 * top, made, None, others, caps=True)


def rows_of(replay: Replay, most: int) -> NDArray[np.int64]:
    """Indices of so many usable samples at the most, evenly spread."""
    usable = np.flatnonzero(replay.usable)
    return usable[:: max(1, math.ceil(len(usable) / most))]
