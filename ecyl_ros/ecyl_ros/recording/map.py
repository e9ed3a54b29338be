"""What a map says: which field of a foreign recording is which signal, and what becomes of it.

A value becomes, in SI, unit x (sign x scale x field + offset), after a field that starts again was
made whole. `map_file` reads and checks the files.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import yaml

from ..arrays import FloatArray
from .signals import FOREIGN_SIGNALS, SIGNALS
from .units import dimension_of, in_si
from .wrap import Wrap, folded, unwrapped

# Name in a map -> dimension of its unit -> field of `Recording`. The first dimension is the one
# of a signal without a unit. `effort` is what the motor is told to give or gives, whatever the
# drive counts it in; its unit says which field that is.
MAPPED: dict[str, dict[str, str]] = {
    "reference_position": {"length": "reference_position_m", "angle": "reference_position_rad"},
    "reference_velocity": {
        "speed": "reference_velocity_m_per_s",
        "angular speed": "reference_velocity_rad_per_s",
    },
    "rotor_position": {"angle": "rotor_position_rad"},
    "rotor_velocity": {"angular speed": "rotor_velocity_rad_per_s"},
    "rotor_torque": {"torque": "rotor_torque_nm"},
    "rod_position": {"length": "rod_position_m"},
    "rod_velocity": {"speed": "rod_velocity_m_per_s"},
    "rod_force": {"force": "rod_force_n"},
    "load_position": {"angle": "load_position_rad"},
    "load_velocity": {"angular speed": "load_velocity_rad_per_s"},
    "current_d": {"current": "current_d_a"},
    "current_q": {"current": "current_q_a"},
    "voltage_d": {"voltage": "voltage_d_v"},
    "voltage_q": {"voltage": "voltage_q_v"},
    "injected_force": {"force": "injected_force_n"},
    "injected_torque": {"torque": "injected_torque_nm"},
    "mode": {"number": "mode"},
    "effort": {
        "torque": "rotor_torque_nm",
        "force": "rod_force_n",
        "current": "current_q_a",
        "voltage": "voltage_q_v",
    },
}
ISO = "iso8601"  # as a unit of time: instants written as dates
# What counts are counts of: their own dimension, and what they become by either key.
BY_COUNTS = {
    "counts": {"counts_per_rev": "angle", "counts_per_m": "length"},
    "counts per second": {"counts_per_rev": "angular speed", "counts_per_m": "speed"},
}
SCHEMA = "ecyl.map/1"
COUNTED = ("counts_per_rev", "counts_per_m")
# What goes on for ever while a drive moves on: only that can be made whole past its end.
POSITIONS = ("length", "angle")


def in_map(target: str) -> str:
    """What a map calls a field of `Recording`, and its unit: `rotor_position in rad`."""
    name = next(name for name, fields in MAPPED.items() if target in fields.values())
    unit = {**SIGNALS, **FOREIGN_SIGNALS}[target]
    return name if unit == "1" else f"{name} in {unit}"


@dataclass(frozen=True)
class MappedSignal:
    """One signal and where it stands.

    Attributes:
        name: as the map calls it, a key of `MAPPED`.
        target: the field of `Recording` that it becomes.
        topic: of a bag, or the file's name without suffix in a folder of CSV files; empty where
            the field names it too, or where the file has no topics.
        field: path within the message (`position[2]`, `wrench.force.x`), column or variable.
        joint: where the field is an array, the name whose place in the message's list of names
            is meant; empty for none.
        unit: as in `UNITS`.
        told: whether the map names the unit; if not, a header may.
        sign, scale, offset: see `in_si`; the offset is in `unit`.
        counts_per_rev, counts_per_m: what a unit of counts is worth; None for other units.
        resolution: step that the field is quantised to, in `unit`; None where that is not known.
        wrap: how the field starts again; None where it does not.
        stamp: `header` or `bag`; empty for header where there is one.
    """

    name: str
    target: str
    field: str
    topic: str = ""
    joint: str = ""
    unit: str = ""
    told: bool = True
    sign: int = 1
    scale: float = 1.0
    offset: float = 0.0
    counts_per_rev: float | None = None
    counts_per_m: float | None = None
    resolution: float | None = None
    wrap: Wrap | None = None
    stamp: str = ""

    @property
    def unit_si(self) -> float:
        """What one of the unit is in SI."""
        if self.counts_per_rev is not None:
            return math.tau / self.counts_per_rev
        return in_si(self.unit) if self.counts_per_m is None else 1.0 / self.counts_per_m

    @property
    def dimension(self) -> str:
        """What the signal measures, a key of `UNITS`; of counts what they are counts of."""
        return next(one for one, field in MAPPED[self.name].items() if field == self.target)

    @property
    def resolution_si(self) -> float | None:
        """Step that the signal is quantised to, in SI; None where that is not known."""
        if self.resolution is not None:
            return self.unit_si * self.resolution
        counted = dimension_of(self.unit) in BY_COUNTS
        return self.unit_si * abs(self.scale) if counted else None

    @property
    def period(self) -> float | None:
        """After how much the field starts again, in its own unit; None where it does not."""
        if self.wrap is None:
            return None
        if math.isfinite(self.wrap.period):
            return self.wrap.period
        return math.tau / (self.unit_si * abs(self.scale))

    def whole(self, values: FloatArray) -> FloatArray:
        """The field as if it never started again; of speeds and efforts only the sign is mended."""
        period = self.period
        if self.wrap is None or period is None:
            return values
        with np.errstate(all="ignore"):
            signed = folded(values, period) if self.wrap.signed else values
            if self.dimension not in POSITIONS:
                return signed
            out = unwrapped(signed, period)
            turn = math.tau / (self.unit_si * abs(self.scale))
            known = out[np.isfinite(out)]
            # Which turn an encoder of one turn stands in is open: the one about zero.
            if known.size and self.dimension == "angle" and math.isclose(period, turn):
                out -= period * np.floor(known[0] / period + 0.5)
            return out

    def in_si(self, values: FloatArray) -> FloatArray:
        """The signal from the field's `whole` values: unit x (sign x scale x value + offset)."""
        with np.errstate(all="ignore"):  # what is not finite is no value, here as elsewhere
            si: FloatArray = self.unit_si * (self.sign * self.scale * values + self.offset)
        return si

    @property
    def where(self) -> str:
        """Topic and field as one path, for messages to the user."""
        return f"{self.topic}.{self.field}" if self.topic else self.field


@dataclass(frozen=True)
class TimeColumn:
    """The instants in a CSV or MAT file.

    Attributes:
        field: column or variable.
        unit: of time, or `ISO`; empty where the map leaves it to the file.
        scale: a factor on it.
        wrap: how the column starts again; None where it does not.
    """

    field: str
    unit: str = ""
    scale: float = 1.0
    wrap: Wrap | None = None


@dataclass(frozen=True)
class SignalMap:
    """What `load_map` returns.

    Attributes:
        source: what messages call the map (a path).
        signals: in the order of `MAPPED`.
        time: of a CSV or MAT file; None where none is named.
        rate_hz: samples per second of a file that holds no time; None otherwise.
        gap_s: a longer pause between samples is kept as a gap; None for a limit from the rate.
    """

    source: str
    signals: tuple[MappedSignal, ...]
    time: TimeColumn | None = None
    rate_hz: float | None = None
    gap_s: float | None = None

    def of(self, target: str) -> MappedSignal | None:
        """The entry that gives a field of `Recording`, if there is one."""
        return next((one for one in self.signals if one.target == target), None)

    def __str__(self) -> str:
        return map_yaml(self)


def map_yaml(signal_map: SignalMap, comment: str = "") -> str:
    """The map as the text of a map file, `load_map` of which gives the same map.

    comment: lines set before it, each becoming a `#` line.
    """
    tree: dict[str, Any] = {"schema": SCHEMA}
    if signal_map.time is not None:
        time = signal_map.time
        tree["time"] = {"field": time.field}
        if time.unit:
            tree["time"]["unit"] = time.unit
        if time.scale != 1.0:
            tree["time"]["scale"] = time.scale
        if time.wrap is not None:
            tree["time"]["wrap"] = time.wrap.in_map
    if signal_map.rate_hz is not None:
        tree["rate"] = signal_map.rate_hz
    if signal_map.gap_s is not None:
        tree["gap"] = signal_map.gap_s
    tree["signals"] = {}
    for one in signal_map.signals:
        entry: dict[str, Any] = {"topic": one.topic} if one.topic else {}
        entry["field"] = one.field
        if one.joint:
            entry["joint"] = one.joint
        if one.told:
            entry["unit"] = one.unit
        for key in (*COUNTED, "resolution"):
            if (value := getattr(one, key)) is not None:
                entry[key] = int(value) if float(value).is_integer() else value
        if one.wrap is not None:
            entry["wrap"] = one.wrap.in_map
        given = {"sign": (one.sign, 1), "scale": (one.scale, 1.0), "offset": (one.offset, 0.0)}
        entry.update({key: own for key, (own, usual) in given.items() if own != usual})
        if one.stamp:
            entry["stamp"] = one.stamp
        tree["signals"][one.name] = entry
    lines = "".join(f"# {line}\n" for line in comment.splitlines())
    return lines + yaml.dump(
        tree, sort_keys=False, default_flow_style=None, width=1000, allow_unicode=True
    )
