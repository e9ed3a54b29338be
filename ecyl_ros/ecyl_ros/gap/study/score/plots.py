"""Calibration curve and confusion table of a study as PNG files."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ....recording.atomic import replacing

DPI = 130


def write_plots(scored: dict[str, Any], folder: Path) -> list[Path]:
    """Write calibration.png and confusion.png into `folder`; returns their paths."""
    written = []
    for name, draw in (("calibration", _calibration), ("confusion", _confusion)):
        path = folder / f"{name}.png"
        with replacing(path) as temporary:
            draw(scored).savefig(temporary, dpi=DPI)
        written.append(path)
    return written


def _calibration(scored: dict[str, Any]) -> Any:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(5.4, 5.0), layout="constrained")
    axis = figure.add_subplot()
    axis.plot([0.0, 1.0], [0.0, 1.0], color="0.6", lw=0.8)
    parts = [part for part in scored["calibration"] if part["count"]]
    for part in parts:
        share, count = part["right"], part["count"]
        low, high = part["ci95"]
        axis.errorbar(
            part["confidence"],
            share,
            # Rounding may leave the share of all or none a little outside its interval.
            yerr=[[max(share - low, 0.0)], [max(high - share, 0.0)]],
            fmt="o",
            color="C0",
            capsize=3,
            ms=4,
            lw=0.9,
        )
        axis.annotate(
            str(count), (part["confidence"], share), xytext=(5, -12), textcoords="offset points"
        )
    axis.set_xlim(0.0, 1.03)
    axis.set_ylim(0.0, 1.03)
    axis.set_xlabel("confidence said")
    axis.set_ylabel("share right")
    axis.set_title("Calibration; numbers are causes named, bars 95 %")
    return figure


def _confusion(scored: dict[str, Any]) -> Any:
    from matplotlib.figure import Figure

    table = scored["confusion"]
    rows = list(table)
    said = {name for row in table.values() for name in row}
    columns = [name for name in rows if name in said]
    columns += sorted(said - set(columns))
    figure = Figure(
        figsize=(4.0 + 0.32 * max(len(columns), 4), 3.2 + 0.24 * max(len(rows), 4)),
        layout="constrained",
    )
    axis = figure.add_subplot()
    if rows:
        counts = np.array([[table[row].get(name, 0) for name in columns] for row in rows])
        axis.imshow(counts, cmap="Blues", aspect="auto", vmin=0, vmax=max(1, counts.max()))
        for (i, j), count in np.ndenumerate(counts):
            if count:
                dark = count > 0.6 * counts.max()
                axis.text(j, i, str(count), ha="center", va="center", color="w" if dark else "k")
        axis.set_xticks(range(len(columns)), columns, rotation=90, fontsize=8)
        axis.set_yticks(range(len(rows)), rows, fontsize=8)
    axis.set_xlabel("named first")
    axis.set_ylabel("true effect, alone in the drive")
    return figure
