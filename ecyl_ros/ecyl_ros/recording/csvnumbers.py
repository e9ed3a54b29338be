"""The cells of a CSV file's column as numbers: plain ones, dates, and lists in a cell."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..arrays import FloatArray
from ..errors import InputError
from .instants import DATE, date_ns

_EXACT = 2**53  # whole numbers up to here are float64s
_LISTED = 64  # entries of a cell that holds a list


class Numbers(NamedTuple):
    """Columns of numbers by name (entries of lists have names of their own), and if dates."""

    values: dict[str, FloatArray]
    dated: bool = False


def numbers(
    column: Any, name: str, asked: list[str], strict: bool, line: int, path: Path
) -> Numbers:
    """What a column of a table holds.

    Args:
        column: as pandas has read it.
        name: of the column.
        asked: what is wanted of it: itself, or entries of its lists.
        strict: whether what is asked for must be there.
        line, path: of the first row, and of the file, for messages.

    Raises:
        InputError: strict, and a cell that is no number or a list without the entry.
    """
    import pandas

    if column.dtype.kind in "fiub":
        if strict and asked != [name]:
            raise InputError(f"{path}: column {name} holds numbers, no lists: {asked[0]}")
        whole = column.to_numpy()
        # Stamps in ns since 1970 have more digits than a float64.
        exact = whole.dtype.kind == "i" and whole.size and int(np.abs(whole).max()) > _EXACT
        return Numbers({name: whole if exact else whole.astype(np.float64)})
    text = column.astype("string").str.strip()
    listed = text.str.startswith("[", na=False)
    if bool(listed.any()):
        return _lists(text, listed, name, asked, strict, line, path)
    dates = _dates(text)
    if dates is not None:
        return Numbers({name: dates}, dated=True)
    found = pandas.to_numeric(text, errors="coerce")
    bad = found.isna() & text.notna()
    if bool(bad.any()):
        if strict:
            row = int(bad.to_numpy().argmax())
            cell = str(text.iloc[row])[:40]
            raise InputError(f"{path}: line {line + row}: {name} is {cell!r}, expected a number")
        return Numbers({})
    return Numbers({name: found.to_numpy(dtype=np.float64, na_value=np.nan)})


def _dates(text: Any) -> FloatArray | None:
    """A column of dates as int64 ns since 1970; None where it is none."""
    given = text.dropna()
    if not len(given) or not DATE.match(str(given.iloc[0])):
        return None
    return date_ns(text)


def _lists(
    text: Any, listed: Any, name: str, asked: list[str], strict: bool, line: int, path: Path
) -> Numbers:
    import pandas

    values: dict[str, FloatArray] = {}
    wanted = [one for one in asked if one != name] if strict else None
    if strict and not wanted:
        raise InputError(f"{path}: column {name} holds lists, expected {name}[0] or so")
    inside = text.where(listed).fillna("").str.strip("[] ")
    sign = "," if inside.str.contains(",").any() else r"\s+"
    parts = inside.str.split(sign, expand=True, regex=sign != ",")
    for i in range(min(parts.shape[1], _LISTED)):
        entry = f"{name}[{i}]"
        if wanted is not None and entry not in wanted:
            continue
        cells = parts[i].str.strip()
        found = pandas.to_numeric(cells, errors="coerce")
        bad = found.isna() & cells.notna() & (cells != "")
        if bool(bad.any()):
            if not strict:
                continue
            row = int(bad.to_numpy().argmax())
            raise InputError(
                f"{path}: line {line + row}: {entry} is {str(cells.iloc[row])[:40]!r}, "
                "expected a number"
            )
        values[entry] = found.to_numpy(dtype=np.float64, na_value=np.nan)
    missing = [entry for entry in wanted or () if entry not in values]
    if missing:
        raise InputError(
            f"{path}: from line {line}: no {missing[0]}: the lists hold {parts.shape[1]} numbers"
        )
    return Numbers(values)
