"""Fig. 9 to 16 as the paper lays them out, one column per reading, as PNG and SVG."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..analysis.bench.identify import Identified
from ..analysis.bench.plot import draw as draw_bench
from ..analysis.emd import Imf
from ..analysis.spectrum import amplitude_spectrum
from ..analysis.tracking import TrackingAnalysis
from ..arrays import FloatArray
from ..recording.atomic import replacing
from . import published
from .readings import half_clearance_m
from .results import Results, error_std
from .runs import CLEARANCE_SHARES
from .tables import percent

DPI = 110
WIDE = (11.0, 3.6)
TALL = (11.0, 6.0)
SHOWN = (("published", "as published: 1.89 N m/rad"), ("si", "in SI: 6499 N m/rad"))
LONG_S = (10.0, 20.0)
MIDDLE_S = (10.0, 15.0)
ONE_S = (18.0, 19.0)
HIGHEST_HZ = 10.0
# Of a legend outside the axes; `loc="outside ..."` is newer than the matplotlib of Ubuntu 24.04.
_BELOW: dict[str, Any] = {"loc": "upper center", "bbox_to_anchor": (0.5, 0.0)}
PAPER = {"color": "0.25", "marker": "D", "ls": "none", "ms": 6}


@dataclass(frozen=True)
class Picture:
    """A figure's file name, its heading, and what draws it."""

    name: str
    title: str
    made: Any


def pictures(results: Results, bench: Identified) -> list[Picture]:
    """All figures, in the paper's order."""
    return [
        Picture("fig09_hysteresis", "Fig. 9: hysteresis loop and its lines", _fig9(bench)),
        Picture("fig10_position", "Fig. 10: reference and position", _fig10(results)),
        Picture("fig11_error", "Fig. 11: position error", _fig11(results)),
        Picture("fig12_imf1", "Fig. 12: first IMF and its spectrum", _imf(results, 0)),
        Picture(
            "fig13_relative_angle", "Fig. 13: relative angle and its spectrum", _fig13(results)
        ),
        Picture("fig14_imf2", "Fig. 14: second IMF and its spectrum", _imf(results, 1)),
        Picture(
            "fig15_stiffness",
            "Fig. 15: first IMF at five stiffnesses",
            _waves(results, "stiffness", published.STIFFNESS_SHARES, 0),
        ),
        Picture(
            "fig16_clearance",
            "Fig. 16: second IMF at five clearances",
            _waves(results, "clearance", CLEARANCE_SHARES, 1),
        ),
        Picture("conclusion", "What the error depends on", _conclusion(results)),
    ]


def write(picture: Picture, folder: Path) -> None:
    """Write NAME.png and NAME.svg, each whole or not at all."""
    for suffix in ("png", "svg"):
        with replacing(folder / f"{picture.name}.{suffix}") as temporary:
            # No date in the file: the same figures give the same bytes.
            extra: dict[str, Any] = {"metadata": {"Date": None}} if suffix == "svg" else {}
            picture.made.savefig(temporary, dpi=DPI, bbox_inches="tight", **extra)


def _grid(rows: int, size: tuple[float, float]) -> tuple[Any, Any]:
    import matplotlib as mpl
    from matplotlib.figure import Figure

    mpl.rcParams["svg.hashsalt"] = "ecyl"
    figure = Figure(figsize=size, layout="constrained")
    axes = figure.subplots(rows, len(SHOWN), squeeze=False, sharey="row")
    for axis in axes.flat:
        axis.grid(True, linewidth=0.4, alpha=0.6)
        axis.spines[["top", "right"]].set_visible(False)
        axis.tick_params(labelleft=True)
    for axis, (_, title) in zip(axes[0], SHOWN, strict=True):
        axis.set_title(title)
    return figure, axes


def _analysis(results: Results, reading: str) -> TrackingAnalysis:
    analysis = results.nominal(reading).analysis
    assert analysis is not None  # runs from rest keep it
    return analysis


def _part(time_s: FloatArray, span: tuple[float, float]) -> Any:
    return (time_s >= span[0]) & (time_s <= span[1])


def _fig9(bench: Identified) -> Any:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.0, 5.6), layout="constrained")
    draw_bench(figure.add_subplot(), bench)
    return figure


def _fig10(results: Results) -> Any:
    figure, axes = _grid(1, WIDE)
    for axis, (key, _) in zip(axes[0], SHOWN, strict=True):
        one = _analysis(results, key)
        time = one.time_s + one.skip_s
        part = _part(time, MIDDLE_S)
        axis.plot(time[part], one.reference_m[part] * 1e3, color="0.35", lw=1.2, label="reference")
        axis.plot(time[part], one.position_m[part] * 1e3, color="C0", lw=1.1, label="rod")
        axis.set_xlim(*MIDDLE_S)
        axis.set_xlabel("time / s")
    axes[0, 0].set_ylabel("position / mm")
    figure.legend(*axes[0, 0].get_legend_handles_labels(), **_BELOW, ncols=2, frameon=False)
    return figure


def _fig11(results: Results) -> Any:
    figure, axes = _grid(1, WIDE)
    for axis, (key, _) in zip(axes[0], SHOWN, strict=True):
        one = _analysis(results, key)
        axis.plot(one.time_s + one.skip_s, one.error_m * 1e3, color="C3", lw=0.8)
        half = half_clearance_m(results.reading(key).drive) * 1e3
        for sign in (-1.0, 1.0):
            axis.axhline(sign * half, color="0.3", lw=0.9, ls="--", label="half the clearance")
        axis.set_xlim(*LONG_S)
        axis.set_xlabel("time / s")
    axes[0, 0].set_ylabel("reference - position / mm")
    handles, names = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles[:1], names[:1], **_BELOW, frameon=False)
    return figure


def _signal_and_spectrum(
    results: Results,
    of: Callable[[str], tuple[FloatArray, FloatArray, float]],
    label: str,
    paper_hz: float,
) -> Any:
    """Signal above, spectrum below; `of` gives time, values in shown units, rate."""
    figure, axes = _grid(2, TALL)
    for column, (key, _) in enumerate(SHOWN):
        time, values, rate = of(key)
        part = _part(time, LONG_S)
        axes[0, column].plot(time[part], values[part], color="C0", lw=0.8)
        axes[0, column].set_xlim(*LONG_S)
        axes[0, column].set_xlabel("time / s")
        spectrum = amplitude_spectrum(values, rate)
        low = spectrum.frequency_hz <= HIGHEST_HZ
        axes[1, column].plot(spectrum.frequency_hz[low], spectrum.amplitude[low], color="C2", lw=1)
        axes[1, column].axvline(paper_hz, color="0.25", lw=0.9, ls="--")
        axes[1, column].set_xlim(0.0, HIGHEST_HZ)
        axes[1, column].set_ylim(bottom=0.0)
        axes[1, column].set_xlabel("frequency / Hz")
    axes[1, 1].text(
        paper_hz + 0.15,
        0.93,
        f"paper: {paper_hz:g} Hz",
        transform=axes[1, 1].get_xaxis_transform(),
        color="0.25",
        fontsize=9,
    )
    axes[0, 0].set_ylabel(label)
    axes[1, 0].set_ylabel(f"amplitude of {label}")
    return figure


def _mode(analysis: TrackingAnalysis, number: int) -> Imf:
    return analysis.emd.imfs[number]


def _imf(results: Results, number: int) -> Any:
    def of(key: str) -> tuple[FloatArray, FloatArray, float]:
        one = _analysis(results, key)
        values = _mode(one, number).values * 1e3
        return one.emd.time_s + one.skip_s, values, one.emd.rate_hz

    paper = published.IMF1_HZ if number == 0 else published.IMF2_HZ
    return _signal_and_spectrum(results, of, f"IMF{number + 1} / mm", paper)


def _fig13(results: Results) -> Any:
    def of(key: str) -> tuple[FloatArray, FloatArray, float]:
        one = _analysis(results, key)
        assert one.relative_angle_rad is not None  # the engine gives the load's angle
        return one.time_s + one.skip_s, one.relative_angle_rad * 1e3, one.rate_hz

    return _signal_and_spectrum(results, of, r"$\Delta\theta$ / mrad", published.RELATIVE_ANGLE_HZ)


def _waves(results: Results, change: str, shares: tuple[float, ...], number: int) -> Any:
    from matplotlib import colormaps

    figure, axes = _grid(1, WIDE)
    colours = colormaps["viridis"](np.linspace(0.05, 0.85, len(shares)))
    for axis, (key, _) in zip(axes[0], SHOWN, strict=True):
        for share, colour in zip(shares, colours, strict=True):
            one = results.at(key, change, share).analysis
            assert one is not None  # runs from rest keep it
            time = one.emd.time_s + one.skip_s
            part = _part(time, ONE_S)
            values = _mode(one, number).values[part] * 1e3
            axis.plot(time[part], values, color=colour, lw=1.3, label=percent(share))
        axis.set_xlim(*ONE_S)
        axis.set_xlabel("time / s")
    axes[0, 0].set_ylabel(f"IMF{number + 1} / mm")
    figure.legend(
        *axes[0, 0].get_legend_handles_labels(),
        **_BELOW,
        ncols=len(shares),
        frameon=False,
        title=change,
    )
    return figure


def _conclusion(results: Results) -> Any:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11.0, 4.0), layout="constrained")
    axes = figure.subplots(1, 2, sharey=True)
    for axis, (change, shares) in zip(
        axes,
        (("stiffness", published.STIFFNESS_SHARES), ("clearance", CLEARANCE_SHARES)),
        strict=True,
    ):
        for reading, colour in zip(results.readings, ("C0", "C9", "C1"), strict=True):
            found = [results.over_starts(reading.key, change, one, error_std) for one in shares]
            axis.errorbar(
                np.array(shares) * 100.0,
                [one.mean * 1e3 for one in found],
                yerr=[one.std * 1e3 for one in found],
                fmt="o-",
                ms=4,
                capsize=3,
                color=colour,
                label=reading.name,
            )
        if change == "stiffness":
            paper = [published.ERROR_STD_M[one] * 1e3 for one in shares]
            axis.plot(np.array(shares) * 100.0, paper, label="paper, Table 3", **PAPER)
        axis.set_xlabel(f"{change} / %")
        axis.grid(True, linewidth=0.4, alpha=0.6)
        axis.spines[["top", "right"]].set_visible(False)
        axis.tick_params(labelleft=True)
    axes[0].set_ylabel("standard deviation of the error / mm")
    axes[0].set_ylim(bottom=0.0)
    figure.legend(*axes[0].get_legend_handles_labels(), **_BELOW, ncols=4, frameon=False)
    return figure
