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
from pathlib import Path
from typing import Any

import yaml

from ..errors import InputError
from .map import (
    BY_COUNTS,
    COUNTED,
    ISO,
    MAPPED,
    POSITIONS,
    SCHEMA,
    MappedSignal,
    SignalMap,
    TimeColumn,
)
from .units import UNITS, dimension_of, plain, unknown_unit
from .wrap import Wrap, parse_wrap

STAMPS = ("header", "bag")
_TOP = ("schema", "signals", "stamp", "joint", "topic", "time", "rate", "gap")
_ENTRY = (
    *("topic", "field", "joint", "unit", "sign", "scale", "offset", "stamp"),
    *(*COUNTED, "resolution", "wrap"),
)
_TIME = ("field", "unit", "scale", "wrap")
_LARGEST = 1_000_000  # bytes of a map file; the largest sensible one has some thousand


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
        for key in COUNTED
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
    for counts, becomes in BY_COUNTS.items():
        names += [one for one in UNITS[counts] if set(becomes.values()) & set(targets)]
    known = ", ".join(names)
    if dimension is None:
        raise InputError(f"{where}.unit: {unknown_unit(unit)}; expected one of {known}")
    keys = BY_COUNTS.get(dimension, {})
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
    if dimension not in POSITIONS and dimension != "time" and not wrap.signed:
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
                        None, None, f"key {_shown(key.value)} appears twice", key.start_mark
                    )
                seen.add(key.value)
        return super().construct_mapping(node, deep=deep)
