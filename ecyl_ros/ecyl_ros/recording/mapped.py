"""Recordings by a map: fields of any bag, CSV or MAT file become the signals of a `Recording`."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray, StampArray
from ..errors import InputError
from . import headers
from .align import Stream, aligned
from .columns import Columns
from .flaws import FROZEN, find_flaws
from .instants import instants, named_column
from .map import MAPPED, MappedSignal, SignalMap, TimeColumn
from .map_file import check_targets
from .screening import HELD, SPEEDS, flaw_notes, left_out, with_sign_notes
from .signals import Recording
from .source import Source, TableSource, Wanted, open_source
from .topics import JOINT_STATE, TOPICS
from .units import UNITS, dimension_of, in_si, unknown_unit
from .wrap import find_wrap, hurried

_TIME_KEY = "time"


def read_mapped(
    path: str | Path,
    signal_map: SignalMap,
    *,
    start_ns: int | None = None,
    stop_ns: int | None = None,
) -> Recording:
    """Read a recording of any kind by a map; see `align.aligned` for how stamps are treated.

    Args:
        path: as `source.open_source` takes it.
        signal_map: which field is which signal.
        start_ns, stop_ns: recorder's times; of a bag, what lies outside is left out. For tables
            they count from the first sample.

    Raises:
        InputError: unreadable, a topic, field, joint or column that is not there, no instants, or
            topics without a time in common.
    """
    source = open_source(path)
    signal_map, unit_notes = with_header_units(source, signal_map)
    wanted = wanted_of(source, signal_map)
    held: dict[str, list[Columns]] = {topic: [] for topic in wanted}
    for part in source.columns(wanted, start_ns=start_ns, stop_ns=stop_ns):
        held[part.topic].append(part)
    entries = {one.target: one for one in signal_map.signals}
    streams = []
    for topic, parts in held.items():
        if not sum(map(len, parts)):
            raise InputError(
                f"{path}: {topic or 'the table'}: no samples{_within(start_ns, stop_ns)}"
            )
        if isinstance(source, TableSource):
            streams.append(_table_stream(source, topic, parts, entries, signal_map))
        else:
            streams += _streams(path, topic, parts, entries, wanted[topic])
        parts.clear()
    for one in streams:
        if not isinstance(source, TableSource):
            _cut(one, start_ns, stop_ns)
        _screen(one, entries)
    recording = aligned(streams, source=str(path), gap_s=signal_map.gap_s)
    steps = {one.target: one.resolution_si for one in signal_map.signals}
    known = {target: step for target, step in steps.items() if step is not None}
    recording = dataclasses.replace(recording, resolution=known)
    if isinstance(source, TableSource) and (start_ns is not None or stop_ns is not None):
        begin, end = (start_ns or 0) / 1e9, (2**62 if stop_ns is None else stop_ns) / 1e9
        recording = recording.slice(begin, end)
    notes = (*source.notes, *(f"{path}: {note}" for note in unit_notes), *recording.notes)
    names = {target: one.name for target, one in entries.items()}
    return with_sign_notes(dataclasses.replace(recording, notes=notes), str(path), names)


def _within(start_ns: int | None, stop_ns: int | None) -> str:
    return "" if start_ns is None and stop_ns is None else " within the time asked for"


def contract_map() -> SignalMap:
    """The map of this project's own topics."""
    names = {field: name for name in MAPPED for field in MAPPED[name].values() if name != "effort"}
    entries = {}
    for topic in TOPICS:
        for path, target in topic.signals.items():
            name = names[target]
            joint, _, last = path.rpartition(".")
            by_joint = topic.type == JOINT_STATE
            entries[name] = MappedSignal(
                name=name,
                target=target,
                field=last if by_joint else path,
                topic=topic.name,
                joint=joint if by_joint else "",
                unit=target_unit(target),
            )
    return SignalMap("the project's own topics", tuple(entries[n] for n in MAPPED if n in entries))


def target_unit(target: str) -> str:
    """SI unit of a field of `Recording`."""
    from .signals import SIGNALS

    return SIGNALS[target]


def wanted_of(source: Source, signal_map: SignalMap) -> dict[str, list[Wanted]]:
    """What to read of each topic; raises InputError for an entry without a topic."""
    wanted: dict[str, list[Wanted]] = {}
    for one in signal_map.signals:
        topic, field = place_of(source, one, signal_map)
        # A table's columns have no joints: the field alone says which.
        joint = "" if isinstance(source, TableSource) else one.joint
        wanted.setdefault(topic, []).append(Wanted(one.target, field, joint))
    if isinstance(source, TableSource):
        for topic, columns in wanted.items():
            column = time_column(source, topic, signal_map)
            if column is not None:
                columns.append(Wanted(_TIME_KEY, column.field))
    return wanted


def with_header_units(source: Source, signal_map: SignalMap) -> tuple[SignalMap, list[str]]:
    """The map with the units that a table's headers tell, where it names none; and notes on these.

    Raises:
        InputError: a header's unit that is not known, or that contradicts the map's.
    """
    if not isinstance(source, TableSource):
        return signal_map, []
    notes: list[str] = []
    signals = []
    for one in signal_map.signals:
        topic, field = place_of(source, one, signal_map)
        table = source.tables.get(topic)
        told = (
            ""
            if table is None
            else header_unit(one, field, table.names, table.units, signal_map.source)
        )
        unit = headers.unit_of(told, MAPPED[one.name]) if told else ""
        if unit and not one.told and unit != one.unit:
            target = MAPPED[one.name][dimension_of(unit) or ""]
            notes.append(f"{one.name}: {unit}, as the header of {field} says")
            one = dataclasses.replace(one, unit=unit, told=True, target=target)
        signals.append(one)
    check_targets(signals, signal_map.source)
    return dataclasses.replace(signal_map, signals=tuple(signals)), notes


def header_unit(
    one: MappedSignal, field: str, names: Sequence[str], units: Mapping[str, str], source: str
) -> str:
    """The unit that a column's header tells of a mapped signal; empty where it tells none.

    Raises:
        InputError: see `with_header_units`.
    """
    column = field if field in names else re.sub(r"\[\d+\]$", "", field)
    if column not in names:
        return ""
    where = f"{source}: signals.{one.name}"
    word = headers.told(column, units.get(column, ""))
    dimensions = MAPPED[one.name]
    if not word:
        # A name's end can mean other things: it counts where the map leaves the unit open.
        ending = headers.ending(column, dimensions)
        return ending if not one.told and len(ending) > 1 and ending not in _WORDS else ""
    unit = headers.unit_of(word, dimensions)
    dimension = dimension_of(unit)
    shown = f"the header of {column[:60]} says {word[:40]}"
    if dimension == "number":
        return ""
    if one.told:
        same = unit == one.unit or (
            dimension == dimension_of(one.unit) and in_si(unit) == in_si(one.unit)
        )
        # With a scale the map converts, and says what the scaled value is in.
        if dimension is not None and not same and one.scale == 1.0:
            raise InputError(
                f"{where}.unit: the map says {one.unit}, but {shown}; expected unit: {unit}, or a "
                "scale that converts"
            )
        return ""
    if dimension is None:
        raise InputError(f"{where}: {shown}, and {unknown_unit(word)}; expected unit in the map")
    if dimension.startswith("counts"):
        raise InputError(
            f"{where}: {shown}; expected unit: {unit} and what they are worth, counts_per_rev or "
            "counts_per_m"
        )
    if dimension not in dimensions:
        known = ", ".join(key for kind in dimensions for key in UNITS[kind])
        raise InputError(
            f"{where}: {shown}, which measures {dimension}, but {one.name} is "
            f"{' or '.join(dimensions)} ({known}); expected unit and scale in the map"
        )
    return unit


_WORDS = ("in", "min", "1")  # units that end names as words


def place_of(source: Source, one: MappedSignal, signal_map: SignalMap) -> tuple[str, str]:
    """Topic and field of an entry, whose field may begin with the topic."""
    if isinstance(source, TableSource) and list(source.tables) == [""]:
        if one.topic:
            raise InputError(
                f"{signal_map.source}: signals.{one.name}.topic: is {one.topic}, but {source.path} "
                "has no topics; expected the field alone"
            )
        return "", one.field
    if one.topic:
        return one.topic, one.field
    topic, point, field = one.field.partition(".")
    if not point or not field:
        raise InputError(
            f"{signal_map.source}: signals.{one.name}: no topic; expected topic, or a field such "
            "as /joint_states.position[0]"
        )
    return topic, field


def time_column(source: TableSource, topic: str, signal_map: SignalMap) -> TimeColumn | None:
    """A table's column of instants; None where a rate is given.

    Raises:
        InputError: the map gives neither, and no column is called as one of instants.
    """
    if signal_map.rate_hz is not None:
        return None
    if signal_map.time is not None:
        return signal_map.time
    table = source.tables.get(topic)
    names: Sequence[str] = [] if table is None else table.names
    if table is not None:
        found = named_column(names, table.units, str(source.path))
        if found is not None:
            return found
    raise InputError(
        f"{signal_map.source}: time is missing: no column of {source.path} has a name of "
        f"time; expected time: {{field: NAME, unit: s}} or rate: HZ; found "
        f"{', '.join(names[:12])}"
    )


def _joined(parts: list[Columns], key: str) -> NDArray:
    return np.concatenate(
        [part.values[key] if key in part.values else np.full(len(part), np.nan) for part in parts]
    )


def _streams(
    path: str | Path,
    topic: str,
    parts: list[Columns],
    entries: dict[str, MappedSignal],
    wanted: list[Wanted],
) -> list[Stream]:
    """A topic's samples; two streams where some of its signals go by header, others by bag."""
    name = topic
    targets = [one.key for one in wanted]
    signals = {target: entries[target].whole(_joined(parts, target)) for target in targets}
    log = np.concatenate([_given(part.log_time_ns) for part in parts])
    header: StampArray | None = None
    if all(part.header_ns is not None for part in parts):
        header = np.concatenate([_given(part.header_ns) for part in parts])
    streams = []
    for by in ("header", "bag"):
        own = {}
        for target in targets:
            asked = entries[target].stamp
            if (asked or "header") == by or (by == "bag" and header is None and not asked):
                own[target] = signals[target]
            if asked == "header" and header is None:
                raise InputError(
                    f"{path}: {topic}: its messages have no header; expected stamp: bag for "
                    f"signals.{entries[target].name}"
                )
        if by == "header" and header is None:
            continue
        if own:
            streams.append(_bag_stream(path, name, log, header, by, own, entries))
    return streams


def _bag_stream(
    path: str | Path,
    name: str,
    log: StampArray,
    header: StampArray | None,
    by: str,
    signals: dict[str, FloatArray],
    entries: dict[str, MappedSignal],
) -> Stream:
    if by == "bag" or header is None:
        return Stream(name, log, log, "bag", signals)
    # A simulation begins at 0; more than one stamp of 0 was never set.
    good = header > 0 if int((header == 0).sum()) > 1 else header >= 0
    if not good.any():
        if any(entries[target].stamp == "header" for target in signals):
            raise InputError(f"{path}: {name}: all header stamps are 0; expected stamp: bag")
        notes = [f"{name}: all header stamps are 0: the recorder's times are used"]
        return Stream(name, log, log, "bag", signals, notes)
    stream = Stream(name, header, log, "header", signals)
    if not good.all():
        stream.notes.append(f"{name}: {int((~good).sum())} samples without a stamp left out")
        stream.keep(good)
    return stream


def _given(stamps: StampArray | None) -> StampArray:
    assert stamps is not None
    return stamps


def _table_stream(
    source: TableSource,
    topic: str,
    parts: list[Columns],
    entries: dict[str, MappedSignal],
    signal_map: SignalMap,
) -> Stream:
    """A table's rows that have a time; signals as the file has them, in the field's own unit."""
    path = str(source.path)
    signals = {
        target: one.whole(_joined(parts, target).astype(np.float64))
        for target, one in entries.items()
        if any(target in part.values for part in parts)
    }
    name = topic or "rows"
    column = time_column(source, topic, signal_map)
    if column is None:
        assert signal_map.rate_hz is not None
        index = np.arange(sum(map(len, parts)))
        stamps = np.round(index * (1e9 / signal_map.rate_hz)).astype(np.int64)
        return Stream(name, stamps, None, "table", signals)
    dated = column.field in source.tables[topic].dated
    found = instants(_joined(parts, _TIME_KEY), column, dated=dated, path=path)
    stream = Stream(name, found.stamps_ns, None, "table", signals)
    stream.notes += [f"{name}: {note}" for note in found.notes]
    if not found.known.all():
        lacking = int((~found.known).sum())
        stream.notes.append(f"{name}: {lacking} rows without {column.field} left out")
        stream.keep(found.known)
    if not stream.stamps_ns.size:
        raise InputError(f"{path}: {name}: no row has a number in {column.field}")
    return stream


def _screen(one: Stream, entries: dict[str, MappedSignal]) -> None:
    """Leave out what says nothing, note what starts again, and put the signals into SI."""
    names = {target: entries[target].name for target in one.signals}
    for target, values in one.signals.items():
        entry = entries[target]
        if entry.wrap is not None:
            if entry.period is not None and hurried(values, entry.period):
                one.notes.append(
                    f"{one.name}: {entry.name}: moves by more than a quarter of {entry.wrap.text} "
                    "in a sample: the direction of the wrap is a guess there"
                )
            continue
        found = find_wrap(values, "" if entry.unit == "counts" else entry.unit)
        if found is not None:
            one.notes.append(
                f"{one.name}: {entry.name}: {found.text}: wrap: {found.wrap.text} in the map makes "
                "it whole"
            )
    si = {target: entries[target].in_si(values) for target, values in one.signals.items()}
    # Whole numbers show the ends of their range before they are scaled; speeds are told in SI.
    flaws = find_flaws(one.stamps_ns, one.signals, held=HELD)
    rates = {name: speed for name, speed in SPEEDS.items() if name in si and speed in si}
    if rates:
        taken = {flaw.fields for flaw in flaws}
        pairs = {name: si[name] for pair in rates.items() for name in pair}
        more = find_flaws(one.stamps_ns, pairs, held=HELD, speeds=rates)
        flaws += [flaw for flaw in more if flaw.kind == FROZEN and flaw.fields not in taken]
    left_out(one.signals, flaws)
    one.signals = {
        target: np.where(np.isnan(one.signals[target]), np.nan, values)
        for target, values in si.items()
    }
    one.notes += [
        f"{one.name}: {note}" for note in flaw_notes(flaws, int(one.stamps_ns.min()), names)
    ]


def _cut(one: Stream, start_ns: int | None, stop_ns: int | None) -> None:
    assert one.log_ns is not None
    inside = np.ones(one.log_ns.size, dtype=bool)
    if start_ns is not None:
        inside &= one.log_ns >= start_ns
    if stop_ns is not None:
        inside &= one.log_ns < stop_ns
    if not inside.all():
        one.keep(inside)
    if not one.stamps_ns.size:
        raise InputError(f"{one.name}: no samples within the time asked for")
