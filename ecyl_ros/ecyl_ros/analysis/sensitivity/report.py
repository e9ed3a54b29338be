"""A sweep as JSON, CSV and a table for the terminal."""

from __future__ import annotations

import csv
import json
from collections.abc import Sequence
from pathlib import Path
from typing import IO, Any

from ...recording.atomic import replacing, write_text
from .sweep import Experiment, Outcome
from .vary import Axis, Point

SCHEMA = "ecyl.sensitivity/1"
IMFS = 2  # those the paper looks at


def as_json(
    drive: str,
    experiment: Experiment,
    axes: Sequence[Axis],
    points: Sequence[Point],
    outcomes: Sequence[Outcome],
) -> dict[str, Any]:
    """Everything in SI units; a run that could not be made has None and an `error`."""
    return {
        "schema": SCHEMA,
        "drive": drive,
        "reference": experiment.reference,
        "duration_s": experiment.duration_s,
        "skip_s": experiment.skip_s,
        "vary": [
            {
                "parameter": axis.key,
                "unit": axis.unit,
                "nominal": axis.nominal,
                "relative": axis.relative,
                "given": list(axis.given),
                "values": list(axis.values),
            }
            for axis in axes
        ],
        "runs": [
            {
                "given": _named(axes, point.given),
                "values": _named(axes, point.values),
                **(outcome.figures or {}),
                "error": outcome.error,
            }
            for point, outcome in zip(points, outcomes, strict=True)
        ],
    }


def _named(axes: Sequence[Axis], values: Sequence[Any]) -> dict[str, Any]:
    return {axis.key: value for axis, value in zip(axes, values, strict=True)}


def write_json(data: dict[str, Any], path: str | Path) -> None:
    """Write what `as_json` made, whole or not at all."""
    write_text(path, json.dumps(data, indent=2, allow_nan=False) + "\n")


def write_csv(
    axes: Sequence[Axis], points: Sequence[Point], outcomes: Sequence[Outcome], path: str | Path
) -> None:
    """One line per run, SI units, empty cells where there is no figure."""
    names = ["error_std_m", "error_rms_m", "error_max_m", "lag_s", "gain"]
    head = [axis.key for axis in axes] + names
    for number in range(1, IMFS + 1):
        head += [f"imf{number}_frequency_hz", f"imf{number}_amplitude_m", f"imf{number}_std_m"]
    with replacing(path) as temporary, temporary.open("w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file)
        rows.writerow([*head, "error"])
        for point, outcome in zip(points, outcomes, strict=True):
            figures = outcome.figures or {}
            row = [_cell(one) for one in point.given]
            row += [_cell(figures.get(name)) for name in names]
            for mode in _modes(outcome):
                row += [_cell(mode.get(k)) for k in ("frequency_hz", "amplitude_m", "std_m")]
            rows.writerow([*row, outcome.error or ""])


def _modes(outcome: Outcome) -> list[dict[str, Any]]:
    modes = list((outcome.figures or {}).get("imfs", []))[:IMFS]
    return modes + [{}] * (IMFS - len(modes))


def _cell(value: Any) -> str:
    if value is None:
        return ""
    if isinstance(value, list):
        return ";".join(repr(one) for one in value)
    return value if isinstance(value, str) else repr(value)


def print_table(
    axes: Sequence[Axis],
    points: Sequence[Point],
    outcomes: Sequence[Outcome],
    file: IO[str] | None = None,
) -> None:
    """One line per run; standard deviation also over that of the nominal drive where it is in."""
    from rich.console import Console
    from rich.table import Table

    console = Console(file=file, highlight=False)
    if not console.is_terminal:
        console = Console(file=file, highlight=False, width=160, color_system=None)
    nominal = _nominal(axes, points, outcomes)
    table = Table(*(_head(axis) for axis in axes), box=None)
    columns = ["std um", *(["of nominal"] if nominal else []), "lag ms"]
    for number in range(1, IMFS + 1):
        columns += [f"IMF{number} Hz", f"IMF{number} um", f"IMF{number} std um"]
    for name in columns:
        table.add_column(name)
    for column in table.columns:
        column.justify = "right"
    failed = 0
    for point, outcome in zip(points, outcomes, strict=True):
        row = [_shown(one) for one in point.given]
        if outcome.figures is None:
            failed += 1
            table.add_row(*row, *["-"] * len(columns))
            continue
        figures = outcome.figures
        row.append(f"{figures['error_std_m'] * 1e6:.3f}")
        if nominal:
            row.append(f"{figures['error_std_m'] / nominal:.3f}")
        row.append(_scaled(figures["lag_s"], 1e3, 2))
        for mode in _modes(outcome):
            row.append(_scaled(mode.get("frequency_hz"), 1.0, 3))
            row.append(_scaled(mode.get("amplitude_m"), 1e6, 3))
            row.append(_scaled(mode.get("std_m"), 1e6, 3))
        table.add_row(*row)
    console.print(table)
    if failed:
        first = next(one.error for one in outcomes if one.error)
        console.print(f"{failed} of {len(points)} drives could not run; the first: {first}")


def _nominal(
    axes: Sequence[Axis], points: Sequence[Point], outcomes: Sequence[Outcome]
) -> float | None:
    for point, outcome in zip(points, outcomes, strict=True):
        if outcome.figures is not None and all(
            value == axis.nominal for axis, value in zip(axes, point.values, strict=True)
        ):
            return float(outcome.figures["error_std_m"])
    return None


def _head(axis: Axis) -> str:
    name = axis.key.removeprefix("transmission.")
    unit = "" if axis.relative or not axis.unit else f" / {axis.unit}"
    return f"{name}{' x' if axis.relative else unit}"


def _shown(value: Any) -> str:
    if isinstance(value, list):
        return ";".join(f"{one:g}" for one in value)
    return value if isinstance(value, str) else f"{value:g}"


def _scaled(value: float | None, scale: float, digits: int) -> str:
    return "-" if value is None else f"{value * scale:.{digits}f}"
