"""Recordings by a map: fields of any bag, CSV or MAT file become the signals of a `Recording`."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from .align import Stream, aligned
from .columns import Columns
from .map import MAPPED, MappedSignal, SignalMap
from .signals import FloatArray, Recording, StampArray
from .source import Source, TableSource, Wanted, open_source
from .topics import JOINT_STATE, TOPICS
from .units import in_si

_TIME_KEY = "time"
_FARTHEST_S = 9.0e9  # seconds that fit an int64 of ns
# Names of a column of instants where a map names none, with the unit they say it is in.
TIME_COLUMNS = {
    "stamp_ns": "ns",
    "timestamp_ns": "ns",
    "time_ns": "ns",
    "timestamp_us": "us",
    "time_us": "us",
    "time_ms": "ms",
    "timestamp_ms": "ms",
    "time_s": "s",
    "__time": "s",
    "time": "s",
    "t": "s",
}


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
            column = time_column(source, topic, signal_map)
            streams.append(_table_stream(path, topic, parts, entries, signal_map, column))
        else:
            streams += _streams(path, topic, parts, entries, wanted[topic])
        parts.clear()
    if not isinstance(source, TableSource):
        for one in streams:
            _cut(one, start_ns, stop_ns)
    recording = aligned(streams, source=str(path), gap_s=signal_map.gap_s)
    if isinstance(source, TableSource) and (start_ns is not None or stop_ns is not None):
        begin, end = (start_ns or 0) / 1e9, (2**62 if stop_ns is None else stop_ns) / 1e9
        recording = recording.slice(begin, end)
    return dataclasses.replace(recording, notes=(*source.notes, *recording.notes))


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
                columns.append(Wanted(_TIME_KEY, column[0]))
    return wanted


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


def time_column(source: TableSource, topic: str, signal_map: SignalMap) -> tuple[str, float] | None:
    """A table's column of instants and what one of its units is in s; None where a rate is given.

    Raises:
        InputError: the map gives neither, and no column is called as one of instants.
    """
    if signal_map.rate_hz is not None:
        return None
    if signal_map.time is not None:
        time = signal_map.time
        return time.field, in_si(time.unit) * time.scale
    names = source.tables[topic].names if topic in source.tables else []
    for name in names:
        if name.lower() in TIME_COLUMNS:
            unit = TIME_COLUMNS[name.lower()]
            told = source.tables[topic].units.get(name, unit)
            return name, in_si(told if told in ("s", "ms", "us", "ns", "min") else unit)
    raise InputError(
        f"{signal_map.source}: time is missing: no column of {source.path} is called as one of "
        f"instants; expected time: {{field: NAME, unit: s}} or rate: HZ; found "
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
    signals = {target: entries[target].in_si(_joined(parts, target)) for target in targets}
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
    path: str | Path,
    topic: str,
    parts: list[Columns],
    entries: dict[str, MappedSignal],
    signal_map: SignalMap,
    time: tuple[str, float] | None,
) -> Stream:
    """A table's rows that have a time."""
    signals = {
        target: one.in_si(_joined(parts, target).astype(np.float64))
        for target, one in entries.items()
        if any(target in part.values for part in parts)
    }
    name = topic or "rows"
    if time is None:
        assert signal_map.rate_hz is not None
        index = np.arange(sum(map(len, parts)))
        stamps = np.round(index * (1e9 / signal_map.rate_hz)).astype(np.int64)
        return Stream(name, stamps, None, "table", signals)
    column, unit_s = time
    raw = _joined(parts, _TIME_KEY)
    known = np.isfinite(raw)
    if raw.dtype.kind == "i" and unit_s == 1e-9:
        stamps = raw.astype(np.int64)
    else:
        seconds = np.where(known, raw, 0.0).astype(np.float64) * unit_s
        if float(np.abs(seconds).max(initial=0.0)) > _FARTHEST_S:
            raise InputError(
                f"{path}: {column} reaches {float(np.abs(seconds).max()):.4g} s; expected a time "
                "(time.unit in the map?)"
            )
        stamps = np.round(seconds * 1e9).astype(np.int64)
    stream = Stream(name, stamps, None, "table", signals)
    if not known.all():
        stream.notes.append(f"{name}: {int((~known).sum())} rows without {column} left out")
        stream.keep(known)
    if not stream.stamps_ns.size:
        raise InputError(f"{path}: {name}: no row has a number in {column}")
    return stream


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
