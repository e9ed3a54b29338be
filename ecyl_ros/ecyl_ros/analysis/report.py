"""Tracking figures as JSON and as a table for the terminal."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import IO, Any

from ..recording.atomic import write_text
from .tracking import TrackingAnalysis


def as_json(analysis: TrackingAnalysis) -> dict[str, Any]:
    """The figures with the names of their fields; SI units; None where a figure has no meaning."""
    emd = analysis.emd
    return {
        "skip_s": analysis.skip_s,
        "duration_s": analysis.duration_s,
        "rate_hz": analysis.rate_hz,
        "samples": analysis.samples,
        "error_std_m": analysis.error_std_m,
        "error_rms_m": analysis.error_rms_m,
        "error_mean_m": analysis.error_mean_m,
        "error_max_m": analysis.error_max_m,
        "lag_s": _number(analysis.lag.lag_s),
        "gain": _number(analysis.lag.gain),
        "lag_reason": analysis.lag.reason or None,
        "spectrum": [
            {"frequency_hz": line.frequency_hz, "amplitude_m": line.amplitude}
            for line in analysis.lines
        ],
        "asked_line": (
            None
            if analysis.asked is None
            else {
                "frequency_hz": analysis.asked.frequency_hz,
                "amplitude_m": analysis.asked.amplitude,
            }
        ),
        "imfs": [
            {
                "frequency_hz": _number(imf.frequency_hz),
                "amplitude_m": _number(imf.amplitude),
                "std_m": imf.std,
                "hilbert_frequency_hz": _number(imf.hilbert_frequency_hz),
                "mixed": _number(imf.mixed),
                "edge_change": _number(imf.edge_change),
            }
            for imf in emd.imfs
        ],
        "emd": {
            "rate_hz": emd.rate_hz,
            "lowpass_hz": emd.lowpass_hz,
            "max_imfs": emd.settings.max_imfs,
            "mirrored_extrema": emd.settings.mirrored_extrema,
            "energy_ratio": _number(emd.energy_ratio),
        },
        "notes": list(analysis.notes),
    }


def write_json(analysis: TrackingAnalysis, path: str | Path) -> None:
    """Write `as_json`, whole or not at all; InputError where that cannot be."""
    write_text(path, json.dumps(as_json(analysis), indent=2, allow_nan=False) + "\n")


def _number(value: float) -> float | None:
    return value if math.isfinite(value) else None


def print_analysis(analysis: TrackingAnalysis, file: IO[str] | None = None) -> None:
    """Print the figures: rich tables on a terminal, the same as plain text in a pipe."""
    from rich.console import Console
    from rich.table import Table

    # A pipe has no width: without one rich would fold lines at 80 columns.
    console = Console(file=file, highlight=False)
    if not console.is_terminal:
        console = Console(file=file, highlight=False, width=120, color_system=None)
    figures = Table.grid(padding=(0, 2))
    figures.add_column()
    figures.add_column(justify="right")
    figures.add_column()
    for name, value, unit in _figures(analysis):
        figures.add_row(name, value, unit)
    console.print(figures)

    emd = analysis.emd
    lines = Table("Hz", "amplitude um", title="Spectrum of the error")
    for line in analysis.lines:
        lines.add_row(_hz(line.frequency_hz), f"{line.amplitude * 1e6:.3f}")
    modes = Table(
        "IMF",
        "Hz (FFT)",
        "Hz (Hilbert)",
        "amplitude um",
        "std um",
        "mixed %",
        "edges %",
        title=f"Empirical modes: {len(emd.imfs)} of at most {emd.settings.max_imfs}, ends mirrored",
    )
    for number, imf in enumerate(emd.imfs, start=1):
        modes.add_row(
            str(number),
            _hz(imf.frequency_hz),
            _hz(imf.hilbert_frequency_hz),
            f"{imf.amplitude * 1e6:.3f}" if math.isfinite(imf.amplitude) else "-",
            f"{imf.std * 1e6:.3f}",
            _percent(imf.mixed),
            _percent(imf.edge_change),
        )
    for table in (lines, modes):
        table.title_justify = "left"
        table.box = None
        for column in table.columns:
            column.justify = "right"
        if table.row_count:
            console.print()
            console.print(table)


def _figures(analysis: TrackingAnalysis) -> list[tuple[str, str, str]]:
    lag = analysis.lag
    rows = [
        ("analysed", f"{analysis.duration_s:.3f}", f"s at {analysis.rate_hz:.6g} Hz"),
        ("error std", f"{analysis.error_std_m * 1e6:.3f}", "um"),
        ("error rms", f"{analysis.error_rms_m * 1e6:.3f}", "um"),
        ("error mean", f"{analysis.error_mean_m * 1e6:.3f}", "um"),
        ("error max", f"{analysis.error_max_m * 1e6:.3f}", "um"),
    ]
    if lag.reason:
        rows.append(("lag, gain", "-", lag.reason))
    else:
        rows += [("lag", f"{lag.lag_s * 1e3:.3f}", "ms"), ("gain", f"{lag.gain:.5f}", "")]
    if analysis.asked is not None:
        at = f"um at {analysis.asked.frequency_hz:.6g} Hz"
        rows.append(("line asked for", f"{analysis.asked.amplitude * 1e6:.3f}", at))
    return rows


def _percent(share: float) -> str:
    return f"{100.0 * share:.1f}" if math.isfinite(share) else "-"


def _hz(value: float) -> str:
    return f"{value:.3f}" if math.isfinite(value) else "-"
