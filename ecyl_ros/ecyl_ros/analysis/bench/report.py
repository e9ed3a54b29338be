"""What the bench found, as JSON and as text for the terminal."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import IO, Any

from ...recording.atomic import write_text
from .budget import BudgetItem
from .coverage import Coverage
from .fit import Estimate
from .identify import Identified
from .units import ARCMIN, ARCSEC
from .write_drive import transmission_values

SCHEMA = "ecyl.bench/1"


def as_json(found: Identified, budget: tuple[BudgetItem, ...]) -> dict[str, Any]:
    """Everything in SI units; None where the loop does not show it, and `notes` says why."""
    fit = found.fit
    return {
        "schema": SCHEMA,
        "source": found.loop.source,
        "readings": int(found.loop.torque_nm.size),
        "edges": {"rising": len(found.edges.rising), "falling": len(found.edges.falling)},
        "points": fit.points,
        "friction_nm": found.curve.friction_nm,
        "shaft_twist_rad_per_nm": found.shaft_twist_rad_per_nm,
        "fit": {
            "k1_rad_per_nm": _json(fit.k1_rad_per_nm),
            "k2_rad_per_nm": _json(fit.k2_rad_per_nm),
            "k3_rad_per_nm": _json(fit.k3_rad_per_nm),
            "t1_nm": _json(fit.t1_nm),
            "t2_nm": _json(fit.t2_nm),
            "angle_zero_rad": fit.angle_zero_rad,
            "torque_zero_nm": fit.torque_zero_nm,
            "misfit_nm": fit.misfit_nm,
        },
        "clearance_rad": {
            **_known(found.clearance_rad),
            "at_torque_nm": found.clearance_torque_nm,
            "read_off_rad": _number(found.clearance_read_rad),
        },
        "dead_zone_rad": _json(fit.clearance_rad),
        "stiffness": [
            {
                "from_nm": one.from_nm,
                "to_nm": one.to_nm if math.isfinite(one.to_nm) else None,
                "nm_per_rad": _json(one.nm_per_rad),
            }
            for one in found.stiffness
        ],
        "secant_nm_per_rad": found.secant_nm_per_rad,
        "error_budget": [
            {"source": one.source, "angle_rad": one.angle_rad, "acts": one.acts} for one in budget
        ],
        "transmission": transmission_values(found),
        "notes": list(found.notes),
    }


def write_json(found: Identified, budget: tuple[BudgetItem, ...], path: str | Path) -> None:
    """Write `as_json`, whole or not at all."""
    write_text(path, json.dumps(as_json(found, budget), indent=2, allow_nan=False) + "\n")


def _known(one: Estimate) -> dict[str, Any]:
    return {"value": one.value, "ci95": [_number(one.low), _number(one.high)]}


def _json(one: Estimate | None) -> dict[str, Any] | None:
    return None if one is None else _known(one)


def _number(value: float) -> float | None:
    return value if math.isfinite(value) else None


def print_identified(
    found: Identified, budget: tuple[BudgetItem, ...], file: IO[str] | None = None
) -> None:
    """Print the figures in the units of Table 1, and in SI where the drive file has them."""
    from rich.console import Console
    from rich.table import Table

    console = Console(file=file, highlight=False)
    if not console.is_terminal:
        console = Console(file=file, highlight=False, width=120, color_system=None)
    fit = found.fit
    rows: list[tuple[str, Estimate | None, float, str, str]] = [
        ("k1", fit.k1_rad_per_nm, ARCMIN, "arcmin/(N m)", ".4f"),
        ("k2", fit.k2_rad_per_nm, ARCMIN, "arcmin/(N m)", ".5f"),
        ("k3", fit.k3_rad_per_nm, ARCMIN, "arcmin/(N m)", ".5f"),
        ("T1", fit.t1_nm, 1.0, "N m", ".4f"),
        ("T2", fit.t2_nm, 1.0, "N m", ".3f"),
        (
            f"backlash between -+{found.clearance_torque_nm:g} N m",
            found.clearance_rad,
            ARCMIN,
            "arcmin",
            ".3f",
        ),
        ("dead zone 2 (k1 - k2) T1", fit.clearance_rad, ARCMIN, "arcmin", ".3f"),
        ("stiffness 1/k2", found.stiffness[0].nm_per_rad, 1.0, "N m/rad", ".1f"),
    ]
    if len(found.stiffness) > 1:
        rows.append(("stiffness 1/k3", found.stiffness[1].nm_per_rad, 1.0, "N m/rad", ".1f"))
    table = _table(Table, ("", "value", "", "95 % interval"), right=(1,))
    for name, one, scale, unit, form in rows:
        if one is None:
            table.add_row(name, "-", unit, "not shown by this loop")
        else:
            low, high = format(one.low / scale, form), format(one.high / scale, form)
            table.add_row(name, format(one.value / scale, form), unit, f"{low} to {high}")
    table.add_row("friction, half the loop's width", f"{found.curve.friction_nm:.3f}", "N m", "")
    console.print(table)
    console.print()
    errors = _table(Table, ("error of the angle", "arcsec", "acts on"), right=(1,))
    for item in budget:
        errors.add_row(item.source, f"{item.angle_rad / ARCSEC:.3f}", item.acts)
    console.print(errors)


def print_coverage(found: Sequence[Coverage], draws: int, file: IO[str] | None = None) -> None:
    """Print how often the 95 % intervals held the truth."""
    from rich.console import Console
    from rich.table import Table

    console = Console(file=file, highlight=False)
    if not console.is_terminal:
        console = Console(file=file, highlight=False, width=120, color_system=None)
    heads = (f"of {draws} draws", "truth in 95 %", "shown", "bias %", "scatter %")
    table = _table(Table, heads, right=(1, 2, 3, 4))
    for one in found:
        table.add_row(
            one.name,
            f"{100.0 * one.inside:.1f} %",
            f"{100.0 * one.shown:.1f} %",
            f"{100.0 * one.bias:+.3f}",
            f"{100.0 * one.scatter:.3f}",
        )
    console.print()
    console.print(table)


def _table(kind: Any, heads: tuple[str, ...], right: tuple[int, ...]) -> Any:
    table = kind(*heads, box=None)
    for place, column in enumerate(table.columns):
        column.justify = "right" if place in right else "left"
    return table
