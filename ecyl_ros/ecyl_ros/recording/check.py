"""A map held against a recording: which fields are there, what they become, what is wrong where."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from ..errors import InputError
from .cdr import CdrError
from .layout import MessageLayout, MessageType
from .load import load_recording, load_stretch
from .map import MappedSignal, SignalMap
from .map_file import parse_map, read_tree
from .mapped import header_unit, place_of, with_header_units
from .signals import FOREIGN_SIGNALS, SIGNALS, Recording
from .signs import WRONG, wrong_signs
from .source import Source, TableSource, Wanted, open_source
from .span import Span
from .stream import BagStream

SCHEMA = "ecyl.map_check/1"
_LONGEST_S = 40.0  # of a large bag, as a diagnosis takes it
# What no drive of this kind reaches: a unit is wrong.
_LARGEST = {"m": 20.0, "m/s": 20.0, "rad/s": 1e4, "A": 2000.0, "V": 2000.0, "N": 1e7, "N m": 1e5}


@dataclass(frozen=True)
class Problem:
    """Something wrong with a map.

    Attributes:
        line: of the map file, from 1; 0 where none can be named.
        text: one line.
        fatal: whether the map cannot be used as it is.
    """

    line: int
    text: str
    fatal: bool = True


@dataclass(frozen=True)
class SignalCheck:
    """One signal as the map gives it.

    Attributes:
        name: in the map.
        where: topic and field.
        target: field of `Recording`; its unit is SI.
        unit: SI.
        count: samples with a value; 0 where the field was not found.
        low, high, mean, std: in SI; NaN without a value.
        resolution: step in SI; None where it is not known.
    """

    name: str
    where: str
    target: str
    unit: str
    count: int
    low: float
    high: float
    mean: float
    std: float
    resolution: float | None


@dataclass(frozen=True)
class MapCheck:
    """What `check_map` returns.

    Attributes:
        source: the map file.
        problems: in order of their lines, the fatal ones first of each.
        signals: that could be read.
        notes: of the reading: what was left out, mended or guessed.
        rate_hz, duration_s: of the recording read; NaN where it could not be.
    """

    source: str
    problems: tuple[Problem, ...]
    signals: tuple[SignalCheck, ...]
    notes: tuple[str, ...]
    rate_hz: float
    duration_s: float

    @property
    def usable(self) -> bool:
        """Whether a recording can be read by the map."""
        return not any(one.fatal for one in self.problems)

    def lines(self) -> list[str]:
        """The problems as `FILE:LINE: what`."""
        return [
            f"{self.source}:{one.line}: {one.text}" if one.line else f"{self.source}: {one.text}"
            for one in self.problems
        ]

    def as_json(self) -> dict[str, Any]:
        """Plain data, schema `ecyl.map_check/1`; SI, None where a figure has no meaning."""
        return {
            "schema": SCHEMA,
            "map": self.source,
            "usable": self.usable,
            "problems": [
                {"line": one.line or None, "text": one.text, "fatal": one.fatal}
                for one in self.problems
            ],
            "signals": [
                {
                    "name": one.name,
                    "field": one.where,
                    "signal": one.target,
                    "unit": one.unit,
                    "count": one.count,
                    "min": _finite(one.low),
                    "max": _finite(one.high),
                    "mean": _finite(one.mean),
                    "std": _finite(one.std),
                    "resolution": one.resolution,
                }
                for one in self.signals
            ],
            "notes": list(self.notes),
            "rate_hz": _finite(self.rate_hz),
            "duration_s": _finite(self.duration_s),
        }


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def check_map(path: str | Path, map_file: str | Path, span: Span | None = None) -> MapCheck:
    """Hold a map file against a recording.

    Every entry is checked by itself, so that one mistake does not hide the next. What is right is
    read, and its ranges are told in SI.

    Raises:
        InputError: the recording or the map file cannot be read at all.
    """
    source = open_source(path)
    tree, lines = read_tree(map_file), key_lines(map_file)
    name = str(map_file)
    problems: list[Problem] = []
    good = _good(tree, name, lines, problems)
    if good is not None:
        good = _found(source, good, name, lines, problems)
    recording = None
    if good is not None:
        recording = _read(path, good, span, lines, problems)
    signals: list[SignalCheck] = []
    if recording is not None and good is not None:
        signals = [_signal(one, recording, lines, problems) for one in good.signals]
        names = {one.target: one.name for one in good.signals}
        for wrong in wrong_signs(recording):
            at = f"signals.{names.get(wrong.signal, '')}"
            text = f"{wrong.text}; {wrong.remedy('', -_sign(good, wrong.signal))}"
            problems.append(Problem(_line(at, lines), f"{at}: {text}", fatal=False))
    problems.sort(key=lambda one: (one.line, not one.fatal))
    return MapCheck(
        name,
        tuple(problems),
        tuple(signals),
        # Wrong signs stand among the problems.
        () if recording is None else tuple(n for n in recording.notes if WRONG not in n),
        math.nan if recording is None else recording.rate_hz,
        math.nan if recording is None else recording.duration_s,
    )


def key_lines(map_file: str | Path) -> dict[str, int]:
    """Each key's path, such as `signals.rod_position.unit`, and the line it stands in, from 1."""
    out: dict[str, int] = {}

    def walk(node: Any, path: str, depth: int) -> None:
        if not isinstance(node, yaml.MappingNode) or depth > 4:
            return
        for key, value in node.value:
            if isinstance(key, yaml.ScalarNode):
                own = f"{path}.{key.value}" if path else str(key.value)
                out.setdefault(own, key.start_mark.line + 1)
                walk(value, own, depth + 1)

    walk(yaml.compose(Path(map_file).read_text(encoding="utf-8"), yaml.SafeLoader), "", 0)
    return out


def _line(where: str, lines: Mapping[str, int]) -> int:
    """The line of a path, or of the nearest key above it."""
    while where:
        if where in lines:
            return lines[where]
        where = where.rpartition(".")[0]
    return 0


def _problem(error: InputError, source: str, lines: Mapping[str, int], at: str = "") -> Problem:
    """An error about a map as a problem in the line that it speaks of."""
    text = str(error).removeprefix(f"{source}: ")
    spoken = text.split(":", 1)[0].split(" ", 1)[0].rstrip(",;")
    line = _line(spoken, lines) if spoken.split(".")[0] in lines else 0
    if "no key called " in text:
        key = text.split("no key called ", 1)[1].split(";", 1)[0]
        own = f"{at}.{key}" if at else key
        line = lines.get(own, lines.get(f"signals.{key}", line))
    return Problem(line or _line(at, lines), text)


def _good(
    tree: Any, source: str, lines: Mapping[str, int], problems: list[Problem]
) -> SignalMap | None:
    """The part of a map that says something sensible; what does not is put among the problems."""
    try:
        return parse_map(tree, source)
    except InputError as error:
        first = error
    entries = tree.get("signals") if isinstance(tree, Mapping) else None
    if not isinstance(entries, Mapping) or not entries:
        problems.append(_problem(first, source, lines))
        return None
    kept: dict[Any, Any] = {}
    rest: dict[Any, Any] = {}
    for key, value in tree.items():  # the whole map's own keys, one by one
        if key == "signals":
            continue
        try:
            parse_map({key: value, "signals": {"mode": "x"}}, source)
            rest[key] = value
        except InputError as error:
            problems.append(_problem(error, source, lines, str(key)))
    for key, value in entries.items():
        try:
            shared = {one: rest[one] for one in ("topic", "joint", "stamp") if one in rest}
            parse_map({**shared, "signals": {**kept, key: value}}, source)
            kept[key] = value
        except InputError as error:
            problems.append(_problem(error, source, lines, f"signals.{key}"))
    try:
        return parse_map({**rest, "signals": kept}, source) if kept else None
    except InputError as error:
        problems.append(_problem(error, source, lines))
        return None


def _found(
    source: Source,
    signal_map: SignalMap,
    name: str,
    lines: Mapping[str, int],
    problems: list[Problem],
) -> SignalMap | None:
    """The part of a map whose topics, fields, joints and columns are there, in units that agree."""
    layouts: dict[str, MessageLayout | str] = {}
    if not isinstance(source, TableSource):
        layouts = _layouts(source.path)
    kept = []
    for one in signal_map.signals:
        at = f"signals.{one.name}"
        try:
            topic, field = place_of(source, one, signal_map)
            if isinstance(source, TableSource):
                table = source.tables.get(topic)
                if table is not None:
                    header_unit(one, field, table.names, table.units, name)
                next(iter(source.columns({topic: [Wanted("x", field)]})), None)
            else:
                _in_bag(source.path, topic, field, one.joint, layouts)
            kept.append(one)
        except InputError as error:
            text = str(error).removeprefix(f"{source.path}: ")
            problems.append(_problem(InputError(text), name, lines, at))
            if at not in problems[-1].text:
                problems[-1] = Problem(problems[-1].line, f"{at}: {problems[-1].text}")
    if not kept:
        return None
    good = SignalMap(
        signal_map.source, tuple(kept), signal_map.time, signal_map.rate_hz, signal_map.gap_s
    )
    try:
        return with_header_units(source, good)[0]
    except InputError as error:
        problems.append(_problem(error, name, lines))
        return None


def _layouts(path: Path) -> dict[str, MessageLayout | str]:
    """Of each topic the structure of its first message, or why it cannot be decoded."""
    out: dict[str, MessageLayout | str] = {}
    for batch in BagStream(path):
        name = batch.topic.name
        if name in out or not batch.start.size:
            continue
        try:
            out[name] = MessageType(batch.topic).layout(batch.message(0))
        except CdrError as error:
            out[name] = str(error)
    return out


def _in_bag(
    path: Path, topic: str, field: str, joint: str, layouts: Mapping[str, MessageLayout | str]
) -> None:
    found = layouts.get(topic)
    if found is None:
        known = ", ".join(sorted(layouts)[:12]) or "none"
        raise InputError(f"{path}: no topic {topic[:80]}; there are {known}")
    if isinstance(found, str):
        raise InputError(f"{path}: {topic}: {found}")
    try:
        found.find(field, joint)
    except CdrError as error:
        raise InputError(f"{path}: {topic}: {error}") from None


def _read(
    path: str | Path,
    signal_map: SignalMap,
    span: Span | None,
    lines: Mapping[str, int],
    problems: list[Problem],
) -> Recording | None:
    try:
        if isinstance(open_source(path), TableSource):
            return load_recording(path, signal_map, span)
        return load_stretch(path, signal_map, _LONGEST_S, span=span)
    except InputError as error:
        text = str(error).removeprefix(f"{path}: ").removeprefix(f"{signal_map.source}: ")
        problems.append(_problem(InputError(text), signal_map.source, lines, "time"))
        return None


def _signal(
    one: MappedSignal, recording: Recording, lines: Mapping[str, int], problems: list[Problem]
) -> SignalCheck:
    values = recording.signal(one.target)
    known = values[np.isfinite(values)]
    unit = (SIGNALS | FOREIGN_SIGNALS)[one.target]
    at = f"signals.{one.name}"

    def remark(text: str) -> None:
        problems.append(Problem(_line(at, lines), f"{at}: {text}", fatal=False))

    if not known.size:
        remark(f"{one.where} has no value at any instant")
        nan = math.nan
        return SignalCheck(
            one.name, one.where, one.target, unit, 0, nan, nan, nan, nan, one.resolution_si
        )
    low, high = float(known.min()), float(known.max())
    if low == high and not one.name.startswith(("reference_", "mode", "injected_")):
        remark(f"{one.where} never changes: it is {low:g} {unit} throughout")
    if max(abs(low), abs(high)) > _LARGEST.get(unit, math.inf):
        remark(
            f"{one.where} ranges from {low:.4g} to {high:.4g} {unit}: more than a drive reaches; "
            f"is its unit {one.unit}?"
        )
    return SignalCheck(
        one.name,
        one.where,
        one.target,
        unit,
        int(known.size),
        low,
        high,
        float(known.mean()),
        float(known.std()),
        one.resolution_si,
    )


def _sign(signal_map: SignalMap, target: str) -> int:
    found = signal_map.of(target)
    return 1 if found is None else found.sign
