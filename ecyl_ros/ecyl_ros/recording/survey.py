"""What a recording holds: topics, fields and their ranges, rates, gaps, clocks, in one pass."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from .clocks import ClockFit, ClockMeter, StampFigures, StampMeter
from .columns import Columns
from .map import SignalMap
from .mapped import time_column
from .source import TableSource, open_source
from .units import in_si

SCHEMA = "ecyl.inspection/1"
_TIME_WORDS = {"time", "timestamp", "stamp", "stamps", "clock", "t"}
_SHORTEST_S, _LONGEST_S = 5e-6, 0.5  # steps that drives are recorded at


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
        time: of a table, its column of instants and the seconds in one of its units.
        time_guessed: whether that unit was guessed from the steps.
    """

    path: str
    kind: str
    topics: tuple[TopicSurvey, ...]
    notes: tuple[str, ...]
    time: tuple[str, float] | None = None
    time_guessed: bool = False

    def as_json(self) -> dict[str, Any]:
        """Plain data, schema `ecyl.inspection/1`; SI and s, None where a figure has no meaning."""
        return {
            "schema": SCHEMA,
            "path": self.path,
            "kind": self.kind,
            "notes": list(self.notes),
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
                        }
                        for f in one.fields
                    ],
                }
                for one in self.topics
            ],
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

    def __init__(self, name: str, kind: str) -> None:
        self.name, self.type = name, kind
        self.log, self.header, self.clock = StampMeter(), StampMeter(), ClockMeter()
        self.has_log = self.has_header = False
        self.figures: dict[str, NDArray[np.float64]] = {}

    def take(self, part: Columns) -> None:
        """The next samples."""
        from .kernels import FIGURES, run_figures

        if part.log_time_ns is not None:
            self.log.take(part.log_time_ns)
            self.has_log = True
        if part.header_ns is not None:
            self.header.take(part.header_ns)
            self.has_header = True
            if part.log_time_ns is not None:
                self.clock.take(part.header_ns, part.log_time_ns)
        for path, values in part.values.items():
            if path not in self.figures:
                self.figures[path] = np.zeros(FIGURES)
            run_figures(np.asarray(values, dtype=np.float64), self.figures[path])

    def survey(
        self, names: dict[str, tuple[str, ...]], units: dict[str, str], unread: str = ""
    ) -> TopicSurvey:
        """The figures."""
        return TopicSurvey(
            self.name,
            self.type,
            self.log.figures() if self.has_log else None,
            self.header.figures() if self.has_header else None,
            self.clock.fit() if self.has_header else None,
            names,
            tuple(_field(path, units, own) for path, own in self.figures.items()),
            unread,
        )


def _field(path: str, units: dict[str, str], figures: NDArray[np.float64]) -> FieldSurvey:
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


def survey(path: str | Path) -> Survey:
    """Look through a recording of any kind, once.

    Raises:
        InputError: unusable as `source.open_source` and the readers say.
    """
    source = open_source(path)
    topics: dict[str, _Topic] = {}
    time: tuple[str, float] | None = None
    guessed = False
    for part in source.columns():
        if part.topic not in topics:
            topics[part.topic] = _Topic(part.topic, part.type)
        own = topics[part.topic]
        if isinstance(source, TableSource):
            if time is None:
                time, guessed = _time_column(source, part, str(path))
            if time is not None and time[0] in part.values:
                own.log.take(_instants(part.values[time[0]], time[1]))
                own.has_log = True
        own.take(part)
    surveys = []
    for name, kind in source.types.items():
        units = source.tables[name].units if isinstance(source, TableSource) else {}
        topic = topics.get(name) or _Topic(name, kind)
        surveys.append(topic.survey(source.names.get(name, {}), units, source.unread.get(name, "")))
    return Survey(str(path), source.kind, tuple(surveys), source.notes, time, guessed)


def _time_column(
    source: TableSource, part: Columns, path: str
) -> tuple[tuple[str, float] | None, bool]:
    """A table's column of instants by its name, and whether its unit is a guess from its steps."""
    try:
        return time_column(source, part.topic, SignalMap(path, ())), False
    except InputError:
        pass
    for name, values in part.values.items():
        words = {word.lower() for word in re.split(r"[^A-Za-z]+", name)}
        steps = np.diff(values)
        if not words & _TIME_WORDS or steps.size < 2 or not (steps >= 0.0).mean() > 0.99:
            continue
        step = float(np.median(steps))
        for unit in ("s", "ms", "us", "ns"):
            if _SHORTEST_S <= step * in_si(unit) <= _LONGEST_S:
                return (name, in_si(unit)), True
    return None, False


def _instants(values: NDArray[Any], unit_s: float) -> NDArray[np.int64]:
    if values.dtype.kind == "i":
        return np.asarray(values * max(1, round(unit_s * 1e9)), dtype=np.int64)
    seconds = values[np.isfinite(values)] * unit_s
    return np.round(seconds[np.abs(seconds) < 9.0e9] * 1e9).astype(np.int64)
