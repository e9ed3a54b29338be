"""A sweep as a picture: curves over one parameter, a map over two."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ...recording.atomic import replacing
from .sweep import Outcome
from .vary import Axis, Point

DPI = 130


def write_plot(
    axes: Sequence[Axis], points: Sequence[Point], outcomes: Sequence[Outcome], folder: str | Path
) -> Path:
    """Write sensitivity.png, whole or not at all; returns where."""
    figure = _curves(axes[0], points, outcomes) if len(axes) == 1 else _maps(axes, outcomes)
    path = Path(folder) / "sensitivity.png"
    with replacing(path) as temporary:
        figure.savefig(temporary, dpi=DPI)
    return path


def _figure(count: int, size: tuple[float, float]) -> tuple[Any, list[Any]]:
    from matplotlib.figure import Figure

    figure = Figure(figsize=size, layout="constrained")
    return figure, [figure.add_subplot(1, count, place + 1) for place in range(count)]


def _places(axis: Axis) -> tuple[np.ndarray, list[str]]:
    """Where values stand, with the names of the ticks (empty: numbers speak for themselves)."""
    if all(isinstance(one, float) for one in axis.given):
        return np.array(axis.given), []
    return np.arange(len(axis.given), dtype=float), [str(one) for one in axis.given]


def _label(axis: Axis) -> str:
    if axis.relative:
        return f"{axis.key} / nominal"
    return f"{axis.key} / ({axis.unit})" if axis.unit else axis.key


def _mode(outcome: Outcome, number: int) -> float:
    modes = (outcome.figures or {}).get("imfs", [])
    return 1e6 * modes[number]["std_m"] if len(modes) > number else np.nan


def _of(outcome: Outcome, name: str, scale: float) -> float:
    value = (outcome.figures or {}).get(name)
    return np.nan if value is None else scale * value


def _curves(axis: Axis, points: Sequence[Point], outcomes: Sequence[Outcome]) -> Any:
    figure, (left, right) = _figure(2, (10.0, 4.2))
    place, names = _places(axis)
    order = np.argsort(place)
    for label, values in (
        ("error", [_of(one, "error_std_m", 1e6) for one in outcomes]),
        ("IMF1", [_mode(one, 0) for one in outcomes]),
        ("IMF2", [_mode(one, 1) for one in outcomes]),
    ):
        left.plot(place[order], np.array(values)[order], "o-", ms=4, label=label)
    left.set_ylabel("standard deviation / µm")
    left.set_ylim(bottom=0.0)
    left.legend(frameon=False)
    lag = np.array([_of(one, "lag_s", 1e3) for one in outcomes])
    right.plot(place[order], lag[order], "o-", ms=4, color="C3")
    right.set_ylabel("lag / ms")
    if np.nanmin(lag) > 0.0:
        right.set_ylim(0.0, 1.1 * np.nanmax(lag))
    for one in (left, right):
        one.set_xlabel(_label(axis))
        one.grid(True, linewidth=0.4, alpha=0.6)
        one.spines[["top", "right"]].set_visible(False)
        if names:
            one.set_xticks(place, names)
    return figure


def _maps(axes: Sequence[Axis], outcomes: Sequence[Outcome]) -> Any:
    figure, panels = _figure(2, (11.0, 4.4))
    (rows, row_names), (columns, column_names) = (_places(axis) for axis in axes)
    shape = (len(rows), len(columns))
    for panel, name, scale, title in (
        (panels[0], "error_std_m", 1e6, "error, standard deviation / µm"),
        (panels[1], "lag_s", 1e3, "lag / ms"),
    ):
        values = np.array([_of(one, name, scale) for one in outcomes]).reshape(shape)
        by_row, by_column = np.argsort(rows), np.argsort(columns)
        drawn = panel.pcolormesh(
            columns[by_column], rows[by_row], values[np.ix_(by_row, by_column)], shading="nearest"
        )
        figure.colorbar(drawn, ax=panel)
        panel.set_title(title)
        panel.set_xlabel(_label(axes[1]))
        panel.set_ylabel(_label(axes[0]))
        if column_names:
            panel.set_xticks(columns, column_names)
        if row_names:
            panel.set_yticks(rows, row_names)
    return figure
