"""Loops that were measured: from CSV or from a recording."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

from ...arrays import FloatArray
from ...errors import InputError
from ...recording.atomic import replacing
from ...recording.csvfile import read_table
from ...recording.reader import read_recording
from .loop import Loop
from .units import ARCMIN, ARCSEC

TORQUE, ANGLE, FORCE, DISPLACEMENT = "torque_nm", "angle_rad", "force_n", "displacement_m"
COLUMNS = (TORQUE, ANGLE, FORCE, DISPLACEMENT)
ANGLE_UNITS = {"rad": 1.0, "mrad": 1e-3, "deg": 60.0 * ARCMIN, "arcmin": ARCMIN, "arcsec": ARCSEC}
MOVED = 5e-6  # m of rod travel from which the output does not count as locked


def read_loop(
    path: str | Path,
    *,
    torque_column: str = TORQUE,
    angle_column: str = ANGLE,
    angle_unit: str = "rad",
) -> tuple[Loop, tuple[str, ...]]:
    """Read a loop, readings in the order of time.

    Args:
        path: a CSV file (`.csv`) with a header line, or a recording: there the torque is
            rotor_torque_nm, torque constant x i_q, and the angle rotor_position_rad.
        torque_column, angle_column: names of the CSV's columns; torque in N m.
        angle_unit: of the CSV's angles: rad, mrad, deg, arcmin or arcsec.

    Returns:
        The loop, and notes on what was left out.

    Raises:
        InputError: the file cannot be read, or lacks one of the two.
    """
    path = Path(path)
    if angle_unit not in ANGLE_UNITS:
        raise InputError(f"angle unit is {angle_unit!r}, expected one of {', '.join(ANGLE_UNITS)}")
    if path.suffix.lower() == ".csv":
        return _from_csv(path, torque_column, angle_column, ANGLE_UNITS[angle_unit]), ()
    return _from_recording(path)


def write_loop(loop: Loop, path: str | Path) -> None:
    """Write a loop as CSV, SI units; `read_loop` reads the same numbers back."""
    columns = {TORQUE: loop.torque_nm, ANGLE: loop.angle_rad}
    if loop.force_n is not None:
        columns[FORCE] = loop.force_n
    if loop.displacement_m is not None:
        columns[DISPLACEMENT] = loop.displacement_m
    with replacing(path) as temporary, temporary.open("w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file)
        rows.writerow(columns)
        rows.writerows(zip(*(map(repr, one.tolist()) for one in columns.values()), strict=True))


def _from_csv(path: Path, torque: str, angle: str, angle_scale: float) -> Loop:
    header, rows = read_table(path, f"{torque} and {angle}")
    for name in (torque, angle):
        if name not in header:
            raise InputError(
                f"{path}: no column {name}; found {', '.join(header)}; name it with "
                f"--{'torque' if name == torque else 'angle'}-column"
            )
    read = {
        name: _column(path, header, rows, name)
        for name in (torque, angle, FORCE, DISPLACEMENT)
        if name in header
    }
    return Loop(
        torque_nm=read[torque],
        angle_rad=read[angle] * angle_scale,
        force_n=read.get(FORCE),
        displacement_m=read.get(DISPLACEMENT),
        source=str(path),
    )


def _column(path: Path, header: list[str], rows: list[list[str]], name: str) -> FloatArray:
    place = header.index(name)
    values = np.empty(len(rows))
    for line, row in enumerate(rows, start=2):
        cell = row[place].strip() if place < len(row) else ""
        try:
            values[line - 2] = float(cell)
        except ValueError:
            raise InputError(
                f"{path}: line {line}: {name} is {cell!r}, expected a number"
            ) from None
    return values


def _from_recording(path: Path) -> tuple[Loop, tuple[str, ...]]:
    recording = read_recording(path)
    for name in ("rotor_torque_nm", "rotor_position_rad"):
        if not recording.has(name):
            raise InputError(f"{path}: {name} is not in the recording; the bench needs it")
    notes = list(recording.notes)
    known = np.isfinite(recording.rotor_torque_nm) & np.isfinite(recording.rotor_position_rad)
    if not known.all():
        notes.append(f"{path}: torque and angle are both known in {known.sum()} of {known.size}")
    rod = recording.rod_position_m[known]
    travel = float(np.ptp(rod[np.isfinite(rod)])) if np.isfinite(rod).any() else 0.0
    if travel > MOVED:
        notes.append(f"{path}: the rod moved by {travel:.3g} m: its output was not locked")
    loop = Loop(
        torque_nm=recording.rotor_torque_nm[known],
        angle_rad=recording.rotor_position_rad[known],
        displacement_m=rod if np.isfinite(rod).all() else None,
        source=str(path),
    )
    return loop, tuple(notes)
