"""The residual, recorded minus simulated, of one signal: over time, position, speed, frequency."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.signal import welch

from ...arrays import FloatArray
from ..diagnosis import Diagnosis
from . import quantities as q
from . import words
from .decimate import quantiles_over
from .markup import figure, typeset
from .stretch import stretches, typeset_label
from .svg import Axis, Chart
from .verdict import strongest

_BINS = 56
_SEGMENT_S = 2.0  # of the spectrum
_BOUNDS = (1e-4, 0.9999)  # quantiles of the residual that the picture over time has room for
_POINTS = 400  # of a spectrum


@dataclass(frozen=True, eq=False)
class Residual:
    """Of the signal with the largest gap over its floor, before and after, at the samples.

    before, after, over arrays: float64[n] in SI units, NaN where not usable.
    """

    name: str
    unit: str
    floor: float
    time_s: FloatArray
    before: FloatArray
    after: FloatArray
    position_m: FloatArray
    position_name: str
    position_unit: str
    speed: FloatArray
    speed_unit: str
    speed_name: str


def residual(diagnosis: Diagnosis) -> Residual | None:
    """The residual worth showing; None where no signal has a floor."""
    about = strongest(diagnosis)
    if about is None:
        return None
    series = diagnosis.series
    names = [one.name for one in diagnosis.signals]
    index = names.index(about.name)
    recorded = np.where(series.usable, series.recorded[index], np.nan)
    position = series.recorded[names.index("rod_position")] if "rod_position" in names else None
    position_name = "rod position"
    if position is None or not np.isfinite(position).any():
        position, position_name = series.reference_m, "reference position"
    if series.position is not None:
        position, position_name = series.position, "position"
    if series.speed is not None:
        speed, speed_unit, speed_name = series.speed, series.speed_unit, "speed"
    elif "rotor_velocity" in names:
        speed = series.recorded[names.index("rotor_velocity")]
        speed_unit, speed_name = "rad/s", "rotor speed"
    else:
        speed = np.gradient(series.reference_m, series.time_s)
        speed_unit, speed_name = "m/s", "speed of the reference"
    return Residual(
        about.name,
        about.unit,
        about.floor,
        series.time_s,
        _finite(recorded - series.before[index]),
        _finite(recorded - series.after[index]),
        position,
        position_name,
        series.position_unit,
        speed,
        speed_unit,
        speed_name,
    )


def _finite(values: FloatArray) -> FloatArray:
    return np.where(np.isfinite(values), values, np.nan)


def figures(diagnosis: Diagnosis) -> str:
    """Four figures; empty where there is nothing to show."""
    left = residual(diagnosis)
    if left is None or not np.isfinite(left.before).any():
        return ""
    both = bool(diagnosis.added)
    made = [
        _over_time(diagnosis, left, both),
        _over(left, left.position_m, left.position_unit, left.position_name, both),
        _over(left, left.speed, left.speed_unit, left.speed_name, both),
        _spectrum(left, both),
    ]
    return f'<div class="pair">{"".join(one for one in made if one)}</div>'


def _label(left: Residual, unit: str) -> str:
    return typeset_label(f"residual of {words.signal(left.name)}", unit)


def _over_time(diagnosis: Diagnosis, left: Residual, both: bool) -> str:
    known = left.before[np.isfinite(left.before)]
    low, high = (float(one) for one in np.quantile(known, _BOUNDS))
    factor, unit = q.engineering(max(abs(low), abs(high)), left.unit)
    room = np.array([low, high, -2.0 * left.floor, 2.0 * left.floor]) * factor
    chart = Chart(
        Axis(float(left.time_s[0]), float(left.time_s[-1]), "time / s"),
        Axis.around(_label(left, unit), room),
        f"Residual of {words.signal(left.name)} over time, before"
        f"{' and after' if both else ''}; held-out stretches shaded",
    )
    for one in stretches(diagnosis.series.held_out):
        chart.shade(float(left.time_s[one.start]), float(left.time_s[one.stop - 1]))
    chart.curve(left.time_s, left.before * factor, "before thin")
    if both:
        chart.curve(left.time_s, left.after * factor, "after thin")
    for sign in (-1.0, 1.0):
        chart.level(sign * left.floor * factor, "floor")
    return figure(str(chart), "Over time. Shaded: held out, no parameter was fitted there.")


def _over(left: Residual, over: FloatArray, unit: str, name: str, both: bool) -> str:
    runs = [("before", left.before)] + ([("after", left.after)] if both else [])
    spreads = [(kind, *quantiles_over(over, values, _BINS)) for kind, values in runs]
    if not any(middles.size for _, middles, _ in spreads):
        return ""
    known = np.concatenate([spread.ravel() for _, _, spread in spreads])
    factor, shown = q.engineering(float(np.abs(known).max()), left.unit)
    across, across_unit = q.engineering(float(np.nanmax(np.abs(over))), unit)
    places = np.concatenate([middles for _, middles, _ in spreads]) * across
    chart = Chart(
        Axis.around(typeset_label(name, across_unit), places, margin=0.01),
        Axis.around(_label(left, shown), known * factor),
        f"Residual of {words.signal(left.name)} over {name}: median and 90 % band",
    )
    for kind, middles, spread in spreads:
        chart.band(middles * across, spread[0] * factor, spread[2] * factor, kind)
        chart.curve(middles * across, spread[1] * factor, kind)
    return figure(str(chart), f"Over {name}: median, and the band that holds 90 %.")


def amplitude_density(
    time_s: FloatArray, values: FloatArray
) -> tuple[float, FloatArray, FloatArray]:
    """Rate in Hz, frequencies and square root of Welch's density of values (unknown ones as 0)."""
    rate = 1.0 / float(np.median(np.diff(time_s)))
    even = np.arange(round((time_s[-1] - time_s[0]) * rate) + 1) / rate + time_s[0]
    filled = np.interp(even, time_s, np.where(np.isfinite(values), values, 0.0))
    segment = max(16, min(filled.size, round(_SEGMENT_S * rate)))
    frequency, density = welch(filled, rate, nperseg=segment, detrend="constant")
    return rate, frequency[1:], np.sqrt(density[1:])


def _thinned(frequency: FloatArray, height: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The highest value in each of `_POINTS` bins of the frequency's logarithm."""
    place = np.log(frequency / frequency[0]) / max(np.log(frequency[-1] / frequency[0]), 1e-9)
    bins = np.minimum((place * _POINTS).astype(np.int64), _POINTS - 1)
    first = np.flatnonzero(np.r_[True, bins[1:] != bins[:-1]]).tolist()
    ends = [*first[1:], height.size]
    peaks = [a + int(np.argmax(height[a:b])) for a, b in zip(first, ends, strict=True)]
    return frequency[peaks], height[peaks]


def _spectrum(left: Residual, both: bool) -> str:
    if left.time_s.size < 64:
        return ""
    rate, frequency, before = amplitude_density(left.time_s, left.before)
    _, _, after = amplitude_density(left.time_s, left.after)
    floor = left.floor * np.sqrt(2.0 / rate)
    shown = [before, after, np.array([floor])] if both else [before, np.array([floor])]
    every = np.concatenate(shown)
    every = every[every > 0.0]
    if every.size == 0:
        return ""
    top = float(every.max())
    factor, unit = q.engineering(top, left.unit)
    low = max(float(np.quantile(every, 0.02)), 1e-6 * top)
    chart = Chart(
        Axis(float(frequency[0]), float(frequency[-1]), "frequency / Hz", logarithmic=True),
        Axis(
            0.5 * low * factor,
            2.0 * top * factor,
            typeset_label(f"residual of {words.signal(left.name)}", f"({unit}/√Hz)"),
            logarithmic=True,
        ),
        f"Spectrum of the residual of {words.signal(left.name)} against the noise floor",
    )
    chart.level(floor * factor, "floor")
    for kind, height in (("before", before), ("after", after)):
        if kind == "before" or both:
            x, y = _thinned(frequency, height * factor)
            chart.curve(x, y, f"{kind} thin")
    return figure(str(chart), typeset("Spectrum. Dashed: the floor if its noise were white."))
