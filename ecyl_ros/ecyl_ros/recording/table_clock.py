"""Which column of a table holds its instants, in which unit, and what is wrong with it."""

from __future__ import annotations

import dataclasses
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from .headers import bare, ending, told
from .instants import TIME_COLUMNS, Instants, epoch_unit, instants, named_column
from .map import ISO, SignalMap, TimeColumn
from .names import words
from .source import TableSource, Wanted
from .units import UNITS, in_si, plain
from .wrap import find_clock_wrap

_TIME_WORDS = {"time", "timestamp", "stamp", "stamps", "clock", "t", "date", "datetime", "utc"}
_SHORTEST_S, _LONGEST_S = 5e-6, 0.2  # steps that drives are recorded at
_SLOWEST_S = 10.0  # between two rows of what may be a log in s
_RISES, _EVEN = 50, 0.1  # even steps by which a column is one of instants, and how even they are


@dataclass(frozen=True)
class TableClock:
    """A table's column of instants, what it holds, and what was guessed or is wrong with it."""

    column: TimeColumn | None = None
    instants: Instants | None = None
    remarks: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()


def table_clock(source: TableSource, topic: str, signal_map: SignalMap | None) -> TableClock:
    """A table's column of instants: the map's, or by its name, its unit by its size or steps."""
    table = source.tables[topic]
    if signal_map is not None and signal_map.rate_hz is not None:
        return TableClock()
    first = next(iter(table.columns()), None)
    values = {} if first is None else first.values
    try:
        given = None if signal_map is None else signal_map.time
        column = (
            given
            or named_column(table.names, table.units, str(source.path))
            or _like_one(table.names, values, table.units, table.dated)
        )
        if column is None:
            return TableClock()
        wanted = {topic: [Wanted("time", column.field)]}
        parts = [part.values["time"] for part in source.columns(wanted)]
        if not parts:
            return TableClock()
        raw = np.concatenate(parts)
        dated = column.field in table.dated
        remarks = []
        if dated and not column.unit:
            column = dataclasses.replace(column, unit=ISO)
            remarks.append(f"time: {column.field} holds dates")
        elif not column.unit:
            unit, step = epoch_unit(raw), _step(raw)
            guess = unit or _unit_by_steps(raw)
            # What is merely called time is in s, unless its size or its steps say that it is not.
            called = bare(column.field).strip().lower() in TIME_COLUMNS
            # Whole numbers that go up unevenly are a counter's: a log by the second is even.
            steps = np.diff(raw)
            counter = bool(steps.size and np.all(raw == np.round(raw)) and np.ptp(steps) > 0.0)
            counter = counter and step > _LONGEST_S
            if not unit and called and step <= _SLOWEST_S and not counter:
                guess = "s"
            column = dataclasses.replace(column, unit=guess or "s")
            if unit:
                remarks.append(
                    f"time: {unit} since 1970 is guessed from the size of {column.field}"
                )
            elif guess != "s" or not called:
                remarks.append(f"time: {column.unit} is guessed from the steps of {column.field}")
            elif step > _LONGEST_S:
                remarks.append(
                    f"time: s is assumed for {column.field}, though it goes up by {step:g}: "
                    "few drives are logged so slowly; say ms, or the rate, if it counts these"
                )
        if column.wrap is None and not dated:
            found = find_clock_wrap(raw.astype(np.float64))
            if found is not None:
                column = dataclasses.replace(column, wrap=found.wrap)
                remarks.append(
                    f"time: {column.field} falls back {found.times} times by {found.wrap.text}, as "
                    "a clock that wraps around does, so wrap is set"
                )
        found_instants = instants(raw, column, dated=dated, path=str(source.path))
        name = f"{topic}: " if topic else ""
        cut = [f"{name}{note}" for note in found_instants.notes if "cut off" in note]
        return TableClock(column, found_instants, tuple(remarks), tuple(cut))
    except InputError as error:
        return TableClock(notes=(str(error),))


def _like_one(
    names: Sequence[str],
    values: Mapping[str, NDArray[Any]],
    units: Mapping[str, str],
    dated: Collection[str],
) -> TimeColumn | None:
    """The column that holds instants though no usual name says so."""
    for name in names:
        if name in dated:
            return TimeColumn(name)
    for name, own in values.items():
        own_words = words(bare(name)) | {bare(name).strip().lower()}
        own = own[: int(np.flatnonzero(own != 0)[-1]) + 1] if (own != 0).any() else own
        steps = np.diff(own)  # but for rows at the end that were never filled
        if not own_words & _TIME_WORDS or steps.size < 2 or not (steps >= 0.0).mean() > 0.9:
            continue
        if not (steps >= 0.0).mean() > 0.99 and find_clock_wrap(own.astype(np.float64)) is None:
            continue
        unit = plain(told(name, units.get(name, "")))
        if unit in UNITS["time"]:
            return TimeColumn(name, unit)
        ended = ending(name, ("time",))
        if ended or epoch_unit(own) or _unit_by_steps(own):
            return TimeColumn(name, ended)
    # As logs have it the first column, where it goes up in even steps of parts of a second.
    name, own = next(iter(values.items()), ("", np.zeros(0)))
    steps = np.diff(own).astype(np.float64)
    step = float(np.median(steps)) if steps.size >= _RISES else 0.0
    if _SHORTEST_S <= step <= _LONGEST_S and np.abs(steps / step - 1.0).max() < _EVEN:
        return TimeColumn(name)
    return None


def _unit_by_steps(values: NDArray[Any]) -> str:
    """The unit by which a drive's steps of time are sensible; empty where none is."""
    step = _step(values)
    if not step:
        return ""
    units = ("s", "ms", "us", "ns")
    return next((unit for unit in units if _SHORTEST_S <= step * in_si(unit) <= _LONGEST_S), "")


def _step(values: NDArray[Any]) -> float:
    """The median of the steps forwards; 0 where there are none."""
    steps = np.diff(values).astype(np.float64)
    ahead = steps[steps > 0.0]
    return float(np.median(ahead)) if ahead.size else 0.0
