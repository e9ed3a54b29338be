"""Map files: which field of a foreign recording is which signal, in which unit, by which clock.

A map file is YAML (docs/recordings.md tells how to write one, `ecyl inspect` proposes one)::

    stamp: header                 # or bag; header where a message has one, unless told
    joint: cylinder               # of every signal that names none
    signals:
      reference_position: {topic: /controller/state, field: "reference.positions", unit: mm}
      rod_position: {topic: /joint_states, field: position, sign: -1}
      rotor_velocity: {topic: /motor, field: "velocity[0]", unit: rpm, scale: 0.1, offset: 3}
      effort: "/joint_states.effort[2]"
    time: {field: t, unit: ms}    # CSV and MAT: where the instants stand; or rate: 1000

and a value becomes, in SI, unit x (sign x scale x field + offset). A field that starts again (an
encoder of 12 bits, an angle of one turn) is made whole by `wrap`, before all that; of one in counts
`counts_per_rev` or `counts_per_m` says what they are worth::

      rotor_position: {field: enc, unit: counts, counts_per_rev: 4096, wrap: 12bit}
"""

from __future__ import annotations

import contextlib
import difflib
import math
import reprlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from ..errors import InputError
from .signals import FloatArray
from .units import UNITS, dimension_of, in_si, plain, unknown_unit
from .wrap import Wrap, folded, parse_wrap, unwrapped

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
STAMPS = ("header", "bag")

_TOP = ("schema", "signals", "stamp", "joint", "topic", "time", "rate", "gap")
_COUNTED = ("counts_per_rev", "counts_per_m")
_ENTRY = (
    *("topic", "field", "joint", "unit", "sign", "scale", "offset", "stamp"),
    *(*_COUNTED, "resolution", "wrap"),
)
_TIME = ("field", "unit", "scale", "wrap")
ISO = "iso8601"  # as a unit of time: instants written as dates
# What counts are counts of: their own dimension, and what they become by either key.
_BY_COUNTS = {
    "counts": {"counts_per_rev": "angle", "counts_per_m": "length"},
    "counts per second": {"counts_per_rev": "angular speed", "counts_per_m": "speed"},
}
SCHEMA = "ecyl.map/1"
_LARGEST = 1_000_000  # bytes of a map file; the largest sensible one has some thousand


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
        counted = dimension_of(self.unit) in _BY_COUNTS
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
            if self.dimension not in _POSITIONS:
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


def load_map(path: str | Path) -> SignalMap:
    """Read and check a map file.

    Raises:
        InputError: unreadable, no YAML, a key or signal of another name, a value of another kind
            or range, a unit that does not measure the signal, or two entries for one signal.
    """
    return parse_map(read_tree(path), str(path))


def read_tree(path: str | Path) -> Any:
    """The plain data of a map file; InputError where it cannot be read or is no YAML."""
    try:
        data = Path(path).read_bytes()
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}; expected a map file") from None
    if len(data) > _LARGEST:
        raise InputError(f"{path}: {len(data)} bytes, expected a map file of {_LARGEST} at most")
    try:
        return yaml.load(data.decode("utf-8"), Loader=_Loader)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark
        place = f" at line {mark.line + 1}" if mark else ""
        raise InputError(f"{path}: not YAML{place}: {error.problem}") from None
    except (yaml.YAMLError, UnicodeDecodeError, RecursionError, ValueError, OverflowError):
        raise InputError(f"{path}: not YAML; expected a map file") from None


def parse_map(tree: Any, source: str) -> SignalMap:
    """The map that plain data (of a YAML file) describes; `source` is what messages call it."""
    if not isinstance(tree, Mapping):
        raise InputError(f"{source}: expected `signals:` and below it signals by name")
    _known_keys(tree, _TOP, source, "")
    if tree.get("schema", SCHEMA) != SCHEMA:
        raise InputError(f"{source}: schema is {_shown(tree['schema'])}, expected {SCHEMA}")
    entries = tree.get("signals")
    if not isinstance(entries, Mapping) or not entries:
        raise InputError(f"{source}: signals is missing or empty; expected signals by name")
    _known_keys(entries, tuple(MAPPED), source, "signals: ")
    shared = {key: _text(tree, key, source, key) for key in ("topic", "joint", "stamp")}
    signals = tuple(
        _signal(name, entries[name], shared, f"{source}: signals.{name}")
        for name in MAPPED
        if name in entries
    )
    check_targets(signals, source)
    time = _time(tree.get("time"), f"{source}: time")
    rate = _number(tree, "rate", f"{source}: rate", above=0.0)
    if time is not None and rate is not None:
        raise InputError(f"{source}: both time and rate; expected one of them")
    gap = _number(tree, "gap", f"{source}: gap", above=0.0)
    return SignalMap(source, signals, time, rate, gap)


def check_targets(signals: Sequence[MappedSignal], source: str) -> None:
    """Refuse two entries that give the same field of `Recording`."""
    taken: dict[str, str] = {}
    for one in signals:
        if one.target in taken:
            raise InputError(
                f"{source}: signals.{one.name} and signals.{taken[one.target]} both give "
                f"{one.target}; expected one of them"
            )
        taken[one.target] = one.name


def _signal(name: str, entry: Any, shared: Mapping[str, str], where: str) -> MappedSignal:
    if isinstance(entry, str):
        entry = {"field": entry}
    if not isinstance(entry, Mapping):
        raise InputError(f"{where}: is {_shown(entry)}, expected a field, or keys such as field")
    _known_keys(entry, _ENTRY, where, "")
    field = _text(entry, "field", where, f"{where}.field")
    if not field:
        raise InputError(f"{where}: no field; expected the path of one, such as position[0]")
    targets = MAPPED[name]
    told = _text(entry, "unit", where, f"{where}.unit")
    unit = plain(told or next(iter(UNITS[next(iter(targets))])))
    counted = {
        key: _number(entry, key, f"{where}.{key}", above=0.0)
        for key in _COUNTED
        if entry.get(key) is not None
    }
    dimension = _measured(name, unit, tuple(counted), where)
    sign = entry.get("sign", 1)
    if isinstance(sign, bool) or sign not in (1, -1):
        raise InputError(f"{where}.sign: is {_shown(sign)}, expected 1 or -1")
    scale = _number(entry, "scale", f"{where}.scale")
    if scale == 0.0:
        raise InputError(f"{where}.scale: is 0, expected any other number")
    offset = _number(entry, "offset", f"{where}.offset")
    resolution = _number(entry, "resolution", f"{where}.resolution", above=0.0)
    wrap = _wrap(entry, where, dimension)
    stamp = _text(entry, "stamp", where, f"{where}.stamp") or shared["stamp"]
    if stamp and stamp not in STAMPS:
        raise InputError(f"{where}: stamp is {_shown(stamp)}, expected header or bag")
    return MappedSignal(
        name=name,
        target=targets[dimension],
        field=field,
        topic=_text(entry, "topic", where, f"{where}.topic") or shared["topic"],
        joint=_text(entry, "joint", where, f"{where}.joint") or shared["joint"],
        unit=unit,
        told=bool(told),
        sign=int(sign),
        scale=1.0 if scale is None else scale,
        offset=0.0 if offset is None else offset,
        counts_per_rev=counted.get("counts_per_rev"),
        counts_per_m=counted.get("counts_per_m"),
        resolution=resolution,
        wrap=wrap,
        stamp=stamp,
    )


def _measured(name: str, unit: str, counted: tuple[str, ...], where: str) -> str:
    """The dimension of a signal in a unit, counts by what they are counts of."""
    targets = MAPPED[name]
    dimension = dimension_of(unit)
    names = [one for key in targets for one in UNITS[key]]
    for counts, becomes in _BY_COUNTS.items():
        names += [one for one in UNITS[counts] if set(becomes.values()) & set(targets)]
    known = ", ".join(names)
    if dimension is None:
        raise InputError(f"{where}.unit: {unknown_unit(unit)}; expected one of {known}")
    keys = _BY_COUNTS.get(dimension, {})
    if not keys and counted:
        raise InputError(f"{where}: {counted[0]} goes with unit: counts, but unit is {unit}")
    fitting = [key for key in keys if keys[key] in targets]
    if not fitting and dimension not in targets:
        raise InputError(
            f"{where}.unit: is {_shown(unit)}, expected one of {known}, as it is "
            f"{_a(' or '.join(targets))} and no {dimension}"
        )
    if not fitting:
        return dimension
    if len(counted) != 1 or counted[0] not in fitting:
        given = f", not {' and '.join(counted)}" if counted else ""
        raise InputError(
            f"{where}: is in counts; expected what they are worth: {' or '.join(fitting)}{given}"
        )
    return keys[counted[0]]


def _a(what: str) -> str:
    return f"{'an' if what[0] in 'aeiou' else 'a'} {what}"


# What goes on for ever while a drive moves on: only that can be made whole past its end.
_POSITIONS = ("length", "angle")


def _wrap(entry: Mapping[Any, Any], where: str, dimension: str) -> Wrap | None:
    value = entry.get("wrap")
    if value is None:
        return None
    wrap = parse_wrap(value)
    if wrap is None:
        raise InputError(
            f"{where}.wrap: is {_shown(value)}, expected a number above 0 (in the field's own "
            "unit), 16bit, signed 16bit, or rev"
        )
    if dimension not in _POSITIONS and dimension != "time" and not wrap.signed:
        raise InputError(
            f"{where}.wrap: is {_shown(value)}, but {_a(dimension)} does not start again; expected "
            "signed 16bit, for a sign that was lost, or none"
        )
    if not math.isfinite(wrap.period) and dimension != "angle":
        raise InputError(
            f"{where}.wrap: is {wrap.text}, but the signal is {_a(dimension)}; expected a number"
        )
    return wrap


def _time(entry: Any, where: str) -> TimeColumn | None:
    if entry is None:
        return None
    if isinstance(entry, str):
        entry = {"field": entry}
    if not isinstance(entry, Mapping):
        raise InputError(f"{where}: is {_shown(entry)}, expected a field, or field, unit and scale")
    _known_keys(entry, _TIME, where, "")
    field = _text(entry, "field", where, f"{where}.field")
    if not field:
        raise InputError(f"{where}: no field; expected the column or variable that holds the time")
    unit = plain(_text(entry, "unit", where, f"{where}.unit"))
    if unit and unit not in (*UNITS["time"], ISO):
        known = ", ".join((*UNITS["time"], ISO))
        raise InputError(f"{where}.unit: is {_shown(unit)}, expected one of {known}")
    scale = _number(entry, "scale", f"{where}.scale", above=0.0)
    wrap = _wrap(entry, where, "time")
    return TimeColumn(field, unit, 1.0 if scale is None else scale, wrap)


def _known_keys(entry: Mapping[Any, Any], known: tuple[str, ...], source: str, what: str) -> None:
    for key in entry:
        if key in known:
            continue
        near = difflib.get_close_matches(str(key)[:80], known, n=1)
        hint = f"did you mean {near[0]}?" if near else f"expected one of {', '.join(known)}"
        raise InputError(f"{source}: {what}no key called {_shown(key)}; {hint}")


def _text(entry: Mapping[Any, Any], key: str, source: str, where: str) -> str:
    value = entry.get(key)
    if value is None:
        return ""
    if isinstance(value, bool | int | float) or not isinstance(value, str) or not value.strip():
        name = where if where.startswith(source) else f"{source}: {where}"
        raise InputError(f"{name}: is {_shown(value)}, expected text (in quotes where need be)")
    return value.strip()


def _number(
    entry: Mapping[Any, Any], key: str, where: str, *, above: float = -math.inf
) -> float | None:
    value = entry.get(key)
    if value is None:
        return None
    if isinstance(value, str):  # YAML 1.1 reads 1e3 (no dot) as text
        with contextlib.suppress(ValueError):
            value = float(value)
    wanted = "a number" if above == -math.inf else f"a number above {above:g}"
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InputError(f"{where}: is {_shown(value)}, expected {wanted}")
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number) or not number > above:
        raise InputError(f"{where}: is {_shown(value)}, expected {wanted}")
    return number


def _shown(value: Any) -> str:
    """A short text of any value, on one line."""
    text = value if isinstance(value, str) else reprlib.repr(value)
    text = " ".join(text.split())
    return text if len(text) <= 60 else f"{text[:57]}..."


class _Loader(yaml.SafeLoader):
    """Refuses keys that stand twice in one mapping: YAML would silently keep the last."""

    def construct_mapping(self, node: Any, deep: bool = False) -> dict[Any, Any]:
        seen = set()
        for key, _ in node.value:
            if key.tag != "tag:yaml.org,2002:merge" and isinstance(key, yaml.ScalarNode):
                if key.value in seen:
                    raise yaml.constructor.ConstructorError(
                        None, None, f"key {_shown(key.value)} stands twice", key.start_mark
                    )
                seen.add(key.value)
        return super().construct_mapping(node, deep=deep)


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
        for key in (*_COUNTED, "resolution"):
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
