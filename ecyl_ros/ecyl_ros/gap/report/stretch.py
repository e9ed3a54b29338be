"""Recorded against simulated on the held-out stretch with the largest gap."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ...arrays import BoolArray, FloatArray
from ...recording.runs import runs_of
from ..diagnosis import Diagnosis
from . import quantities as q
from . import words
from .markup import figure, typeset
from .svg import Axis, Chart

_MOST_SIGNALS = 3  # beside one another before and after
_MOST_ALONE = 4  # where there is no after
_LEAST_SAMPLES = 8
_HUGE = 1e100  # what a simulation that ran away counts as
_ABOVE_NOISE = 2.0  # signals whose gap is less over their floor are not worth a picture


@dataclass(frozen=True)
class Stretch:
    """Rows start to stop - 1 of the series, contiguous, held out and usable."""

    start: int
    stop: int

    @property
    def rows(self) -> slice:
        """For indexing."""
        return slice(self.start, self.stop)


def stretches(mask: BoolArray) -> list[Stretch]:
    """The runs of True."""
    return [Stretch(start, stop) for start, stop in runs_of(mask).tolist()]


def _rms(values: FloatArray) -> FloatArray:
    """RMS of the finite values of each row; 0 where there are none."""
    known = np.isfinite(values)
    squares = np.clip(np.where(known, values, 0.0), -_HUGE, _HUGE) ** 2
    mean: FloatArray = np.sqrt(squares.sum(axis=-1) / np.maximum(known.sum(axis=-1), 1))
    return mean


def worst(diagnosis: Diagnosis) -> Stretch | None:
    """The held-out stretch with the largest pooled gap before; None where none is held out."""
    series = diagnosis.series
    known = [
        one
        for one in stretches(series.held_out & series.usable)
        if one.stop - one.start >= _LEAST_SAMPLES
    ]
    if not known:
        return None
    middle = [
        np.mean(values[np.isfinite(values)] if np.isfinite(values).any() else 0.0)
        for values in series.recorded
    ]
    spread = _rms(series.recorded - np.array(middle)[:, None])
    left = (series.recorded - series.before) / np.where(spread > 0.0, spread, np.inf)[:, None]
    return max(known, key=lambda one: float(np.sum(_rms(left[:, one.rows]) ** 2)))


def telling_signals(diagnosis: Diagnosis, stretch: Stretch) -> list[int]:
    """The few signals in which the gap is seen best: largest beside what the signal does."""
    series = diagnosis.series
    recorded = series.recorded[:, stretch.rows]
    left = _rms(recorded - series.before[:, stretch.rows])
    seen = []
    for index, one in enumerate(diagnosis.signals):
        values = recorded[index][np.isfinite(recorded[index])]
        if values.size < _LEAST_SAMPLES or math.isnan(one.gap):  # nothing to be seen beside it
            continue
        travel = float(np.ptp(values)) or 1.0
        seen.append((left[index] > _ABOVE_NOISE * one.floor, left[index] / travel, index))
    seen.sort(reverse=True)
    most = _MOST_SIGNALS if diagnosis.added else _MOST_ALONE
    shown = [index for loud, _, index in seen if loud][:most]
    return shown or [index for _, _, index in seen[:most]]


def figures(diagnosis: Diagnosis, stretch: Stretch) -> str:
    """A figure a signal with the nominal model, and one beside it with the causes added."""
    series = diagnosis.series
    time = series.time_s[stretch.rows]
    made = []
    runs = [("before", "nominal model", series.before)]
    if diagnosis.added:
        added = f"{diagnosis.added} added"
        runs.append(("after", added, series.after))
    for index in telling_signals(diagnosis, stretch):
        about = diagnosis.signals[index]
        recorded = series.recorded[index, stretch.rows]
        factor, unit = q.engineering(float(np.nanmax(np.abs(recorded), initial=0.0)), about.unit)
        name = words.signal(about.name)
        curves = [run[index, stretch.rows] * factor for _, _, run in runs]
        label = typeset_label(name, unit)
        y = _within(recorded * factor, curves, label, _travel(series.recorded[index]) * factor)
        for (kind, title, run), simulated in zip(runs, curves, strict=True):
            left = float(_rms(recorded - run[index, stretch.rows]))
            rms = q.amount(left, about.unit)
            text = f"{name}, recorded and simulated, {title}; RMS of the difference {rms}"
            chart = Chart(Axis(float(time[0]), float(time[-1]), "time / s"), y, text)
            chart.curve(time, recorded * factor, "recorded")
            chart.curve(time, simulated, kind)
            over = q.times(left, about.floor)
            caption = f"{name}, {title}: difference {rms} RMS, {over} x floor"
            made.append(figure(str(chart), typeset(caption[:1].upper() + caption[1:])))
    return f'<div class="pair">{"".join(made)}</div>'


def typeset_label(name: str, unit: str) -> str:
    """Axis label as plain text, its unit in type."""
    import html

    return html.unescape(typeset(f"{name} / {unit}")) if unit not in ("", "1") else name


def _travel(values: FloatArray) -> float:
    known = values[np.isfinite(values)]
    return float(np.ptp(known)) if known.size else 0.0


def _within(
    recorded: FloatArray, curves: list[FloatArray], label: str, travel: float = 0.0
) -> Axis:
    """Room for the recording, and for the simulations where they do not run away from it.

    travel: of the signal over the whole recording, which a simulation may be off by.
    """
    known = recorded[np.isfinite(recorded)]
    low, high = float(known.min()), float(known.max())
    reach = max(high - low, travel) or 1.0
    near = [np.clip(one[np.isfinite(one)], low - reach, high + reach) for one in curves]
    return Axis.around(label, known, *near)
