"""Recordings as CSV: one column of stamps in ns and one per signal, by its name."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ..arrays import FloatArray
from ..errors import InputError
from .atomic import replacing
from .signals import FOREIGN_SIGNALS, SIGNALS, Recording

STAMP = "stamp_ns"
_NAMES = (*SIGNALS, *FOREIGN_SIGNALS)


def write_csv(recording: Recording, path: str | Path) -> None:
    """Write the measured signals; a missing value is an empty cell.

    Numbers are written with as many digits as it takes to read the same number back.

    Raises:
        InputError: the file cannot be written.
    """
    names = [name for name in _NAMES if recording.has(name)]
    columns = [_cells(recording.signal(name)) for name in names]
    with replacing(path) as temporary, temporary.open("w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file)
        rows.writerow([STAMP, *names])
        rows.writerows(zip(recording.stamp_ns.tolist(), *columns, strict=True))


def _cells(values: FloatArray) -> list[str]:
    return ["" if value != value else repr(value) for value in values.tolist()]


def read_table(path: str | Path, expected: str) -> tuple[list[str], list[list[str]]]:
    """Header and rows of a CSV file as text; `expected`: what its header should hold.

    Raises InputError where the file cannot be read, is no CSV text, or is empty.
    """
    try:
        with Path(path).open(newline="", encoding="utf-8-sig") as file:
            table = list(csv.reader(file))
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None
    except (UnicodeDecodeError, csv.Error) as error:
        raise InputError(f"{path}: is no CSV text: {error}") from None
    if not table:
        raise InputError(f"{path}: is empty, expected a header line with {expected}")
    return [name.strip() for name in table[0]], table[1:]


def read_csv(path: str | Path, *, columns: Mapping[str, str] | None = None) -> Recording:
    """Read a CSV file with a header line.

    Args:
        path: the file.
        columns: signal (or `stamp_ns`) -> the file's own name for that column, where it differs.
            Other columns of the file are ignored.

    Raises:
        InputError: no such file, no stamp column, none of the signals, a cell that is no number,
            a row of another length, or stamps that do not increase.
    """
    own = dict(columns or {})
    header, rows = read_table(path, STAMP)
    stamp_column = own.get(STAMP, STAMP)
    if stamp_column not in header:
        raise InputError(f"{path}: no column {stamp_column}; found {', '.join(header)}")
    places = {
        name: header.index(own.get(name, name)) for name in _NAMES if own.get(name, name) in header
    }
    if not places:
        raise InputError(f"{path}: no column with a signal's name, such as rod_position_m")
    for line, row in enumerate(rows, start=2):
        if len(row) != len(header):
            raise InputError(f"{path}: line {line}: {len(row)} cells, expected {len(header)}")
    stamp_place = header.index(stamp_column)
    stamps = np.empty(len(rows), dtype=np.int64)
    for i, row in enumerate(rows):
        try:
            stamps[i] = int(row[stamp_place])
        except (ValueError, OverflowError):
            raise InputError(
                f"{path}: line {i + 2}: {stamp_column} is {row[stamp_place]!r}, expected whole ns"
            ) from None
    wrong = np.flatnonzero(stamps[1:] <= stamps[:-1])
    if wrong.size:
        raise InputError(f"{path}: line {wrong[0] + 3}: {stamp_column} does not increase")
    signals: dict[str, Any] = {
        name: _column(path, header, rows, place) for name, place in places.items()
    }
    return Recording(stamp_ns=stamps, **signals)


def _column(path: str | Path, header: list[str], rows: list[list[str]], place: int) -> FloatArray:
    values = np.empty(len(rows))
    for i, row in enumerate(rows):
        cell = row[place].strip()
        try:
            values[i] = float(cell) if cell else np.nan
        except ValueError:
            raise InputError(
                f"{path}: line {i + 2}: {header[place]} is {cell!r}, expected a number"
            ) from None
    return values
