"""The figures of an analysis as PNG files, laid out like the paper's figures 10 to 14."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..arrays import FloatArray
from ..recording.atomic import replacing
from .spectrum import Line, Spectrum, amplitude_spectrum
from .tracking import TrackingAnalysis

SIZE = (9.0, 4.2)
TALL = (9.0, 6.4)
DPI = 130
# Beyond this many points a line is drawn by the lowest and highest value of each pixel column.
MAX_POINTS = 6000
QUIET = 0.02  # a spectrum is shown up to where it last exceeds this part of its highest line


def write_plots(analysis: TrackingAnalysis, folder: str | Path) -> list[Path]:
    """Write position.png, error.png, imf_N.png, relative_angle.png and spectrum.png.

    relative_angle.png is written where the load was recorded. Lengths are shown in um, mm or m
    and angles in mrad or urad, whichever keeps the numbers short. Existing files of these names
    are replaced, each whole or not at all.

    Returns:
        The files written.

    Raises:
        InputError: the folder or a file cannot be written.
    """
    out = Path(folder)
    figures: dict[str, Any] = {
        "position": _position(analysis),
        "error": _error(analysis),
        "spectrum": _spectrum(analysis),
    }
    for number, imf in enumerate(analysis.emd.imfs, start=1):
        figures[f"imf_{number}"] = _signal_and_spectrum(
            f"IMF{number} of the position error",
            f"IMF{number}",
            analysis.emd.time_s + analysis.skip_s,
            imf.values,
            analysis.emd.rate_hz,
            "m",
        )
    if analysis.relative_angle_rad is not None:
        figures["relative_angle"] = _signal_and_spectrum(
            "Relative angle, rotor less load",
            r"$\Delta\theta$",
            analysis.time_s + analysis.skip_s,
            analysis.relative_angle_rad,
            analysis.rate_hz,
            "rad",
        )
    written = []
    for name, figure in figures.items():
        path = out / f"{name}.png"
        with replacing(path) as temporary:
            figure.savefig(temporary, dpi=DPI)
        written.append(path)
    return written


def _figure(rows: int, size: tuple[float, float]) -> tuple[Any, list[Any]]:
    # Figure without pyplot: no display, no global state.
    from matplotlib.figure import Figure

    figure = Figure(figsize=size, layout="constrained")
    axes = [figure.add_subplot(rows, 1, row + 1) for row in range(rows)]
    for axis in axes:
        axis.grid(True, linewidth=0.4, alpha=0.6)
        axis.spines[["top", "right"]].set_visible(False)
    return figure, axes


def _position(analysis: TrackingAnalysis) -> Any:
    figure, (axis,) = _figure(1, SIZE)
    scale, unit = _unit(np.concatenate((analysis.reference_m, analysis.position_m)), "m")
    time = analysis.time_s + analysis.skip_s
    axis.plot(*_drawn(time, analysis.reference_m * scale), color="0.35", lw=1.2, label="reference")
    axis.plot(*_drawn(time, analysis.position_m * scale), color="C0", lw=1.0, label="rod position")
    _time_axis(axis, time)
    axis.set_ylabel(f"position / {unit}")
    axis.set_title("Reference and rod position")
    # Above the axes, where no curve runs.
    axis.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, frameon=False)
    return figure


def _error(analysis: TrackingAnalysis) -> Any:
    figure, (axis,) = _figure(1, SIZE)
    scale, unit = _unit(analysis.error_m, "m")
    time = analysis.time_s + analysis.skip_s
    axis.plot(*_drawn(time, analysis.error_m * scale), color="C3", lw=0.9)
    _time_axis(axis, time)
    axis.set_ylabel(f"reference - position / {unit}")
    axis.set_title(
        f"Position error: standard deviation {analysis.error_std_m * scale:.3g} {unit}, "
        f"largest {analysis.error_max_m * scale:.3g} {unit}"
    )
    return figure


def _spectrum(analysis: TrackingAnalysis) -> Any:
    figure, (axis,) = _figure(1, SIZE)
    _draw_spectrum(axis, analysis.spectrum, "m", name_lines=analysis.lines[:5])
    axis.set_title("Spectrum of the position error")
    return figure


def _signal_and_spectrum(
    title: str, symbol: str, time_s: FloatArray, values: FloatArray, rate_hz: float, unit: str
) -> Any:
    figure, (top, bottom) = _figure(2, TALL)
    scale, shown = _unit(values, unit)
    top.plot(*_drawn(time_s, values * scale), color="C0", lw=0.9)
    _time_axis(top, time_s)
    top.set_ylabel(f"{symbol} / {shown}")
    top.set_title(title)
    _draw_spectrum(bottom, amplitude_spectrum(values, rate_hz), unit)
    return figure


def _draw_spectrum(
    axis: Any, spectrum: Spectrum, unit: str, name_lines: Sequence[Line] = ()
) -> None:
    scale, shown = _unit(spectrum.amplitude, unit)
    height = spectrum.amplitude * scale
    loud = np.flatnonzero(height > QUIET * height.max()) if height.max() > 0 else np.array([1])
    last = min(height.size, int(loud[-1] * 1.3) + 2)
    axis.plot(*_drawn(spectrum.frequency_hz[:last], height[:last]), color="C2", lw=1.0)
    axis.set_xlim(0.0, float(spectrum.frequency_hz[last - 1]))
    top = max([float(height.max()), *(line.amplitude * scale for line in name_lines)])
    axis.set_ylim(0.0, 1.1 * top if top > 0.0 else 1.0)
    axis.set_xlabel("frequency / Hz")
    axis.set_ylabel(f"amplitude / {shown}")
    handles = [
        axis.plot(
            line.frequency_hz,
            line.amplitude * scale,
            "o",
            ms=4,
            label=f"{line.frequency_hz:.3g} Hz, {line.amplitude * scale:.3g} {shown}",
        )[0]
        for line in name_lines
    ]
    if handles:
        axis.legend(handles=handles, loc="upper right", frameon=False)


def _unit(values: FloatArray, unit: str) -> tuple[float, str]:
    """Factor and name that bring the largest value to between 1 and 1000 where possible."""
    largest = float(np.abs(values).max()) if values.size else 0.0
    for scale, prefix in ((1.0, ""), (1e3, "m"), (1e6, "u")):
        if largest * scale >= 1.0:
            return scale, prefix.replace("u", "µ") + unit
    return (1e9, "n" + unit) if 0.0 < largest < 1e-7 else (1e6, "µ" + unit)


def _time_axis(axis: Any, time_s: FloatArray) -> None:
    axis.set_xlim(float(time_s[0]), float(time_s[-1]))
    axis.set_xlabel("time / s")


def _drawn(x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The curve with few enough points to draw, no peak lost."""
    if x.size <= MAX_POINTS:
        return x, y
    group = -(-x.size // (MAX_POINTS // 2))
    whole = x.size // group * group
    rows = y[:whole].reshape(-1, group)
    first = np.arange(rows.shape[0]) * group
    picked = np.sort(
        np.concatenate((first + rows.argmin(axis=1), first + rows.argmax(axis=1), [x.size - 1]))
    )
    return x[picked], y[picked]
