"""How a machine goes over time: its gap, and the size of every cause that is named twice."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..report import quantities as q
from ..report import words
from ..report.svg import Axis, Chart
from .entry import Entry, Size

_DAY_NS, _HOUR_NS, _MINUTE_NS = 86_400 * 10**9, 3_600 * 10**9, 60 * 10**9
# Recordings are dots: a line of no length with round ends.
MARKS = """
a { color: var(--after); }
.curve.dot { stroke-width: 7; stroke-linecap: round; }
"""


def trend(entries: Sequence[Entry]) -> list[tuple[str, str]]:
    """(picture, caption) of one machine's gap, and of causes; none of a single recording."""
    order = sorted(entries, key=lambda one: (one.start_ns, one.name))
    if len(order) < 2:
        return []
    begin = order[0].start_ns
    unit, label = _unit(order[-1].start_ns - begin)
    if unit:
        times = np.array([(one.start_ns - begin) / unit for one in order])
    else:  # no clock tells them apart: in the order of their names
        times, label = np.arange(1.0, len(order) + 1.0), "recording"
    x = Axis.around(label, times)
    gaps = np.array([one.gap for one in order])
    chart = Chart(x, Axis.around("gap, noise floors", gaps, np.zeros(1)), "gap over time")
    chart.curve(times, gaps, "thin before")
    chart.level(1.0, "floor")
    _dots(chart, times, gaps, "before")
    found = [(str(chart), "Misfit of the nominal model; dashed: noise.")]
    effects = dict.fromkeys(size.effect for one in order for size in one.causes)
    for effect in effects:
        made = _sizes(order, times, x, effect)
        if made is not None:
            found.append(made)
    return found


def _sizes(
    order: Sequence[Entry], times: np.ndarray, x: Axis, effect: str
) -> tuple[str, str] | None:
    named: list[tuple[float, Size]] = [
        (time, size)
        for time, one in zip(times.tolist(), order, strict=True)
        for size in one.causes
        if size.effect == effect
    ]
    if len(named) < 2:
        return None
    first = named[0][1]
    largest = max(abs(size.value) for _, size in named)
    factor, unit = q.engineering(largest, first.unit)
    at = np.array([time for time, _ in named])
    values = factor * np.array([size.value for _, size in named])
    low = factor * np.array([size.low for _, size in named])
    high = factor * np.array([size.high for _, size in named])
    label = q.parameter_label(first.parameter)
    y = Axis.around(f"{label}, {unit}" if unit not in ("", "1") else label, low, high)
    chart = Chart(x, y, f"{words.title(effect)} over time")
    chart.curve(at, values, "thin after")
    for place, bottom, top in zip(at, low, high, strict=True):
        chart.curve(np.array([place, place]), np.array([bottom, top]), "after")
    _dots(chart, at, values, "after")
    title = words.title(effect)
    return str(chart), f"{title[:1].upper() + title[1:]}, with its 95 % interval."


def _dots(chart: Chart, x: np.ndarray, y: np.ndarray, kind: str) -> None:
    for across, up in zip(x.tolist(), y.tolist(), strict=True):
        chart.curve(np.array([across, across]), np.array([up, up]), f"dot {kind}")


def _unit(span_ns: int) -> tuple[int, str]:
    for unit, label in ((_DAY_NS, "days"), (_HOUR_NS, "hours"), (_MINUTE_NS, "minutes")):
        if span_ns >= 2 * unit:
            return unit, f"{label} since the first"
    return (10**9, "seconds since the first") if span_ns > 0 else (0, "")
