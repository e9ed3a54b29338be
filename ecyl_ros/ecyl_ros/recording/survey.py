"""What a recording holds: topics, fields and their ranges, rates, gaps, clocks, in one pass."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ..arrays import BoolArray, FloatArray, StampArray
from ..errors import InputError
from .clocks import ClockFit, ClockMeter, StampFigures, StampMeter
from .columns import Columns
from .flaws import Flaw
from .health import HealthMeter
from .map import SignalMap, TimeColumn
from .source import TableSource, open_source
from .span import Span
from .table_clock import TableClock, table_clock
from .wrap import WrapFound

SCHEMA = "ecyl.inspection/1"


@dataclass(frozen=True)
class FieldSurvey:
    """One field's finite values.

    Attributes:
        path: of the field, or name of the column.
        unit: where the file says it; empty otherwise.
        count: finite values.
        low, high, mean, std: of these; NaN where there are none.
        travel: sum of all steps' sizes.
        turns: how often the steps changed sign.
        equal: share of values that equal the one before: 1 where nothing ever changes.
        whole: whether all values are whole numbers.
        wrap: how it starts again; None where it does not.
    """

    path: str
    unit: str
    count: int
    low: float
    high: float
    mean: float
    std: float
    travel: float
    turns: int
    equal: float
    whole: bool = False
    wrap: WrapFound | None = None


@dataclass(frozen=True)
class TopicSurvey:
    """One topic.

    Attributes:
        name, type: of the topic; a table without topics has an empty name.
        log, header: figures of the recorder's stamps and of the messages' own; None without any.
            Of a table `log` is that of its column of instants.
        clock: the recorder's clock against the messages' stamps; None without one of them.
        names: joint names by path.
        fields: of all numbers.
        flaws: stretches that say nothing.
        unread: why its messages could not be decoded; empty where they could.
    """

    name: str
    type: str
    log: StampFigures | None
    header: StampFigures | None
    clock: ClockFit | None
    names: dict[str, tuple[str, ...]] = field(default_factory=dict)
    fields: tuple[FieldSurvey, ...] = ()
    unread: str = ""
    flaws: tuple[Flaw, ...] = ()

    @property
    def stamps(self) -> StampFigures | None:
        """The messages' own where they have any, else the recorder's."""
        if self.header is not None and self.header.last_ns > 0:
            return self.header
        return self.log


@dataclass(frozen=True)
class Survey:
    """What `survey` returns.

    Attributes:
        path, kind: of the recording; see `source`.
        topics: all met.
        notes: what was cut off or could not be read.
        time: of a table, its column of instants.
        time_remarks: what of that was guessed or found.
    """

    path: str
    kind: str
    topics: tuple[TopicSurvey, ...]
    notes: tuple[str, ...]
    time: TimeColumn | None = None
    time_remarks: tuple[str, ...] = ()

    @property
    def origin_ns(self) -> int | None:
        """The first stamp of all; None where nothing has a stamp."""
        found = [one.stamps.first_ns for one in self.topics if one.stamps is not None]
        return min(found, default=None)

    def flaw_lines(self) -> list[str]:
        """A line on each stretch that says nothing and each field that starts again."""
        lines = []
        for topic in self.topics:
            name = f"{topic.name}: " if topic.name else ""
            origin = None if topic.stamps is None else self.origin_ns
            lines += [f"{name}{flaw.text(origin)}" for flaw in topic.flaws]
            lines += [
                f"{name}{one.path}: {one.wrap.text}: wrap: {one.wrap.wrap.text} in the map makes "
                "it whole"
                for one in topic.fields
                if one.wrap is not None
            ]
        return lines

    def as_json(self) -> dict[str, Any]:
        """Plain data, schema `ecyl.inspection/1`; SI and s, None where a figure has no meaning."""
        return {
            "schema": SCHEMA,
            "path": self.path,
            "kind": self.kind,
            "notes": list(self.notes),
            "time": None
            if self.time is None
            else {
                "field": self.time.field,
                "unit": self.time.unit or None,
                "wrap": None if self.time.wrap is None else self.time.wrap.in_map,
                "remarks": list(self.time_remarks),
            },
            "topics": [
                {
                    "name": one.name,
                    "type": one.type,
                    "unread": one.unread or None,
                    "log": _stamps(one.log),
                    "header": _stamps(one.header),
                    "clock": None
                    if one.clock is None
                    else {
                        "log_less_header_s": one.clock.offset_s,
                        "drift_ppm": one.clock.drift * 1e6,
                        "drift_error_ppm": one.clock.drift_error * 1e6,
                        "delay_median_s": one.clock.delay_s,
                    },
                    "names": {path: list(names) for path, names in one.names.items()},
                    "fields": [
                        {
                            "path": f.path,
                            "unit": f.unit or None,
                            "count": f.count,
                            "min": _number(f.low),
                            "max": _number(f.high),
                            "mean": _number(f.mean),
                            "std": _number(f.std),
                            "unchanged": _number(f.equal),
                            "wrap": None
                            if f.wrap is None
                            else {"wrap": f.wrap.wrap.in_map, "times": f.wrap.times},
                        }
                        for f in one.fields
                    ],
                    "flaws": [self._flaw(one, flaw) for flaw in one.flaws],
                }
                for one in self.topics
            ],
        }

    def _flaw(self, topic: TopicSurvey, flaw: Flaw) -> dict[str, Any]:
        origin = None if topic.stamps is None else self.origin_ns
        begin, end = (
            None if origin is None else (at - origin) / 1e9 for at in (flaw.begin_ns, flaw.end_ns)
        )
        return {
            "kind": flaw.kind,
            "fields": list(flaw.fields),
            "from_s": begin,
            "to_s": end,
            "rows": [flaw.begin, flaw.end],
            "samples": flaw.samples,
            "text": flaw.text(origin),
        }


def _number(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _stamps(one: StampFigures | None) -> dict[str, Any] | None:
    if one is None:
        return None
    return {
        "count": one.count,
        "first_ns": one.first_ns,
        "last_ns": one.last_ns,
        "rate_hz": _number(one.rate_hz),
        "step_s": _number(one.step_s),
        "jitter_s": _number(one.jitter_s),
        "repeated": one.repeated,
        "backward": one.backward,
        "jumps": one.jumps,
        "lost": one.lost,
        "gaps": [{"at_s": at, "length_s": length} for at, length in one.gaps],
    }


class _Topic:
    """Running figures of one topic."""

    def __init__(self, name: str, kind: str, units: dict[str, str]) -> None:
        self.name, self.type = name, kind
        self._units = units
        self._health = HealthMeter(name, units)
        self.log, self.header, self.clock = StampMeter(), StampMeter(), ClockMeter()
        self.has_log = self.has_header = False
        self.figures: dict[str, FloatArray] = {}

    def take(self, part: Columns, instants_ns: StampArray | None = None) -> None:
        """The next samples; of a table with their instants."""
        from .kernels import FIGURES, run_figures

        if instants_ns is not None:
            self.log.take(instants_ns)
            self.has_log = True
        if part.log_time_ns is not None:
            self.log.take(part.log_time_ns)
            self.has_log = True
        if part.header_ns is not None:
            self.header.take(part.header_ns)
            self.has_header = True
            if part.log_time_ns is not None:
                self.clock.take(part.header_ns, part.log_time_ns)
        stamps = instants_ns if instants_ns is not None else _stamps_of(part)
        if part.values and stamps.size == len(part):
            self._health.take(stamps, part.values)
        for path, values in part.values.items():
            if path not in self.figures:
                self.figures[path] = np.zeros(FIGURES)
            run_figures(np.asarray(values, dtype=np.float64), self.figures[path])

    def survey(self, names: dict[str, tuple[str, ...]], unread: str = "") -> TopicSurvey:
        """The figures."""
        flaws, wraps = self._health.found()
        whole = self._health.whole
        return TopicSurvey(
            self.name,
            self.type,
            self.log.figures() if self.has_log else None,
            self.header.figures() if self.has_header else None,
            self.clock.fit() if self.has_header else None,
            names,
            tuple(
                dataclasses.replace(
                    _field(path, self._units, own),
                    whole=whole.get(path, False),
                    wrap=wraps.get(path),
                )
                for path, own in self.figures.items()
            ),
            unread,
            flaws,
        )


def _stamps_of(part: Columns) -> StampArray:
    """The messages' own stamps where they are set, else the recorder's, else the rows."""
    header = part.header_ns
    if header is not None and bool((header > 0).all()):
        return header
    return np.arange(len(part)) if part.log_time_ns is None else part.log_time_ns


def _field(path: str, units: dict[str, str], figures: FloatArray) -> FieldSurvey:
    from .kernels import COUNT, EQUAL, FIRST, MAXIMUM, MINIMUM, SQUARES, TOTAL, TRAVEL, TURNS

    count = int(figures[COUNT])
    if not count:
        nan = math.nan
        return FieldSurvey(path, units.get(path, ""), 0, nan, nan, nan, nan, 0.0, 0, nan)
    mean = float(figures[TOTAL]) / count
    variance = max(float(figures[SQUARES]) / count - mean * mean, 0.0)
    mean += float(figures[FIRST])
    return FieldSurvey(
        path=path,
        unit=units.get(path, ""),
        count=count,
        low=float(figures[MINIMUM]),
        high=float(figures[MAXIMUM]),
        mean=mean,
        std=math.sqrt(variance) if math.isfinite(variance) else math.nan,
        travel=float(figures[TRAVEL]),
        turns=int(figures[TURNS]),
        equal=float(figures[EQUAL]) / (count - 1) if count > 1 else math.nan,
    )


def survey(
    path: str | Path, span: Span | None = None, signal_map: SignalMap | None = None
) -> Survey:
    """Look through a recording of any kind, once.

    Args:
        path: as `source.open_source` takes it.
        span: the part to look at; all by default.
        signal_map: a map whose column of instants is taken.

    Raises:
        InputError: unusable as `source.open_source` and the readers say, or without samples in
            the span.
    """
    source = open_source(path)
    topics: dict[str, _Topic] = {}
    clocks: dict[str, TableClock] = {}
    if isinstance(source, TableSource):
        clocks = {topic: table_clock(source, topic, signal_map) for topic in source.tables}
    rows: dict[str, int] = {}
    first: int | None = None
    for part in source.columns():
        if part.topic not in topics:
            units = source.tables[part.topic].units if isinstance(source, TableSource) else {}
            topics[part.topic] = _Topic(part.topic, part.type, units)
        begin = rows.get(part.topic, 0)
        rows[part.topic] = begin + len(part)
        found = clocks[part.topic].instants if part.topic in clocks else None
        own = None
        if found is not None:
            known = found.known[begin : begin + len(part)]
            own = found.stamps_ns[begin : begin + len(part)]
            if not known.all():
                part, own = _chosen(part, known), own[known]
        if span is not None:
            when = own if own is not None else part.log_time_ns
            if when is None:
                raise InputError(
                    f"{path}: --from and --to need instants: no column is called as one of "
                    "instants; expected a map with time or rate (--map)"
                )
            if first is None and when.size:
                first = int(when[0])
            if first is not None:
                seconds = (when - first) / 1e9
                inside = (seconds >= span.begin_s) & (seconds < span.end_s)
                part, own = _chosen(part, inside), None if own is None else own[inside]
        topics[part.topic].take(part, own)
    surveys = []
    for name, kind in source.types.items():
        topic = topics.get(name) or _Topic(name, kind, {})
        surveys.append(topic.survey(source.names.get(name, {}), source.unread.get(name, "")))
    if span is not None and not any(one.log is not None and one.log.count for one in surveys):
        raise InputError(f"{path}: no samples {span.text}; expected --from and --to within it")
    notes = tuple(
        dict.fromkeys((*source.notes, *(n for one in clocks.values() for n in one.notes)))
    )
    clock = next((one for one in clocks.values() if one.column is not None), None)
    if clock is None:
        return Survey(str(path), source.kind, tuple(surveys), notes)
    return Survey(str(path), source.kind, tuple(surveys), notes, clock.column, clock.remarks)


def _chosen(part: Columns, rows: BoolArray) -> Columns:
    return Columns(
        part.topic,
        part.type,
        None if part.log_time_ns is None else part.log_time_ns[rows],
        None if part.header_ns is None else part.header_ns[rows],
        {path: values[rows] for path, values in part.values.items()},
    )
