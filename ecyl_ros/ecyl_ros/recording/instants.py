"""When the rows of a table were sampled: which column, in which unit, dates, clocks that wrap."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..arrays import BoolArray, FloatArray, StampArray
from ..errors import InputError
from .headers import bare, told
from .map import ISO, TimeColumn
from .names import unnamed
from .units import UNITS, in_si, plain, unknown_unit
from .wrap import folded, unwrapped

# Names of a column of instants where a map names none, with the unit they say it is in; those that
# say none are in s, unless their size speaks of another.
TIME_COLUMNS = {
    "stamp_ns": "ns",
    "timestamp_ns": "ns",
    "time_ns": "ns",
    "timestamp_us": "us",
    "time_us": "us",
    "t_us": "us",
    "time_ms": "ms",
    "timestamp_ms": "ms",
    "t_ms": "ms",
    "time_s": "s",
    "timestamp_s": "s",
    "t_s": "s",
    "us": "us",
    "ms": "ms",
    "s": "s",
    "sec": "s",
    "seconds": "s",
    "__time": "",
    "time": "",
    "t": "",
}
NO_STAMP = np.iinfo(np.int64).min  # of a row whose cell holds no date
DATE = re.compile(
    r"\d{4}-\d{2}-\d{2}[T ]\d{2}:\d{2}(:\d{2}([.,]\d{1,9})?)?\s*(Z|[+-]\d{2}:?\d{2}|[+-]\d{2})?$"
)
_EPOCH_S = (9.0e8, 5.0e9)  # 1998 to 2128
_STEP_S = (1e-7, 60.0)  # what steps of such a column may be
_FARTHEST_S = 9.0e9  # seconds that fit an int64 of ns


def date_ns(text: Any) -> NDArray[Any] | None:
    """Dates by ISO 8601 as int64 ns since 1970, `NO_STAMP` for missing ones.

    A date without Z or offset is taken as UTC. None where a cell is no such date.
    """
    import pandas

    plain_text = text.str.replace(",", ".", regex=False)
    try:
        found = pandas.to_datetime(plain_text, format="ISO8601", utc=True, errors="coerce")
        whole = found.dt.tz_localize(None).astype("datetime64[ns]")
    except (ValueError, OverflowError):  # beyond what ns can say
        return None
    if bool((whole.isna() & text.notna()).any()):
        return None
    return np.asarray(whole.to_numpy().astype(np.int64))


def epoch_unit(values: NDArray[Any]) -> str:
    """The unit in which a column counts since 1970, by its size and its steps; empty for none."""
    known = values[values != NO_STAMP] if values.dtype.kind == "i" else values[np.isfinite(values)]
    if known.size < 2:
        return ""
    middle = float(np.median(known))
    steps = np.diff(known).astype(np.float64)
    ahead = steps[steps > 0.0]
    step = float(np.median(ahead)) if ahead.size else 0.0
    for unit in ("s", "ms", "us", "ns"):
        one = in_si(unit)
        if _EPOCH_S[0] <= middle * one < _EPOCH_S[1] and _STEP_S[0] <= step * one <= _STEP_S[1]:
            return unit
    return ""


def named_column(names: Sequence[str], units: Mapping[str, str], where: str) -> TimeColumn | None:
    """The column that is called as one of instants, and the unit that its header tells, if any;
    else one without a name whose unit is of time.

    Raises:
        InputError: its header tells a unit that is none of time.
    """
    for name in names:
        key = bare(name).strip().lower()
        if key not in TIME_COLUMNS:
            continue
        word = told(name, units.get(name, ""))
        unit = plain(word)
        if word and unit not in UNITS["time"] and unit.lower().replace(" ", "") not in (ISO, "utc"):
            raise InputError(
                f"{where}: column {name[:60]}: {unknown_unit(word)}; expected one of time, or "
                "time: {field: NAME, unit: ms} in the map"
            )
        return TimeColumn(name, (unit if unit in UNITS["time"] else "") or TIME_COLUMNS[key])
    for name in names:
        unit = plain(units.get(name, ""))
        if unnamed(name) and unit in UNITS["time"]:
            return TimeColumn(name, unit)
    return None


@dataclass(frozen=True)
class Instants:
    """Instants of a table's rows.

    Attributes:
        stamps_ns: int64[n].
        known: bool[n], where there is one.
        unit: that the column is in.
        notes: what was guessed or mended.
    """

    stamps_ns: StampArray
    known: BoolArray
    unit: str
    notes: tuple[str, ...] = ()


def instants(raw: NDArray[Any], column: TimeColumn, *, dated: bool, path: str) -> Instants:
    """The instants that a column holds.

    Args:
        raw: the column, int64 where a float64 would round it.
        column: its name, unit, scale and wrap as the map or the header has them.
        dated: whether it held dates, `raw` being ns then.
        path: what messages call the file.

    Raises:
        InputError: a unit that contradicts dates, or numbers too large for a time.
    """
    name = column.field
    if dated and column.unit not in ("", ISO, *(("ns",) if column.scale == 1.0 else ())):
        raise InputError(
            f"{path}: time.unit is {column.unit}, but column {name} holds dates; expected {ISO}"
        )
    if column.unit == ISO and not dated:
        raise InputError(f"{path}: time.unit is {ISO}, but column {name} holds numbers, no dates")
    notes: list[str] = []
    unit = "ns" if dated else column.unit
    if not unit:
        unit = epoch_unit(raw)
        if unit:
            notes.append(f"{name} is taken for {unit} since 1970, by its size")
        unit = unit or "s"
    known = raw != NO_STAMP if raw.dtype.kind == "i" else np.isfinite(raw)
    known = np.asarray(known, dtype=np.bool_)
    if column.wrap is not None and not dated:
        period = column.wrap.period
        values = np.where(known, raw, np.nan).astype(np.float64)
        values = folded(values, period) if column.wrap.signed else values
        steps = np.diff(values[known])
        times = int((np.abs(steps) > 0.5 * period).sum())
        raw = _onward(values, period)
        notes.append(f"{name} wraps around {times} times, after {column.wrap.text}: unwrapped")
    empty = zeros_at_the_end(raw, known)
    if empty.any():
        known &= ~empty
        notes.append(f"the end is cut off: {int(empty.sum())} rows whose {name} is 0")
    factor = in_si(unit) * column.scale
    if raw.dtype.kind == "i" and factor == 1e-9:
        return Instants(np.where(known, raw, 0).astype(np.int64), known, unit, tuple(notes))
    seconds = np.where(known, raw, 0.0).astype(np.float64) * factor
    farthest = float(np.abs(seconds).max(initial=0.0))
    if farthest > _FARTHEST_S:
        raise InputError(
            f"{path}: {name} reaches {farthest:.4g} s; expected a time (time.unit in the map?)"
        )
    stamps = np.round(seconds * 1e9).astype(np.int64)
    tick = round(factor * 1e9)
    if tick >= 1 and abs(tick - factor * 1e9) < 1e-9 * tick:
        ticks = np.where(known, raw, 0)
        if bool((ticks == np.round(ticks)).all()):  # whole ms and us since 1970 keep every digit
            stamps = ticks.astype(np.int64) * tick
    return Instants(stamps, known, unit, tuple(notes))


def _onward(values: FloatArray, period: float) -> FloatArray:
    """A clock made whole: it never goes back by more than a tenth of its period."""
    out = values.copy()
    at = np.flatnonzero(np.isfinite(values))
    steps = np.diff(values[at])
    # Samples late by a little may stand out of order; what falls far has started again.
    turns = np.cumsum(np.where(steps < -0.1 * period, np.ceil((-steps - 0.1 * period) / period), 0))
    out[at[1:]] += period * turns
    if bool((steps > 0.9 * period).any()):  # out of order just there: back over the end
        return unwrapped(values, period)
    return out


def zeros_at_the_end(raw: NDArray[Any], known: BoolArray) -> BoolArray:
    """Rows that a logger left empty: their time is 0 behind times above it."""
    out = np.zeros(raw.size, dtype=np.bool_)
    filled = np.flatnonzero(known & (raw != 0))
    if filled.size > 1 and filled[-1] + 1 < raw.size and raw[filled[-1]] > raw[filled[0]] >= 0:
        out[filled[-1] + 1 :] = known[filled[-1] + 1 :]
    return out
