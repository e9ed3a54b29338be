"""Tables that go to CSV as numbers and to HTML as text."""

from __future__ import annotations

import csv
import io
import math
from dataclasses import dataclass, field

Cell = str | float | int | None


@dataclass(frozen=True)
class Column:
    """A heading, with its unit, and how numbers below it are shown."""

    head: str
    form: str = ".4g"


@dataclass(frozen=True)
class Table:
    """Attributes:
    name: of its files.
    title: one line.
    columns, rows: as many cells as columns; None is shown as a dash.
    note: what the reader has to know to check it; may be empty.
    """

    name: str
    title: str
    columns: tuple[Column, ...]
    rows: tuple[tuple[Cell, ...], ...] = field(repr=False)
    note: str = ""

    def __post_init__(self) -> None:
        for row in self.rows:
            if len(row) != len(self.columns):
                raise ValueError(f"{self.name}: {len(row)} cells for {len(self.columns)} columns")

    def csv(self) -> str:
        """The table as CSV text; numbers with all their digits, empty cells for what is not."""
        out = io.StringIO()
        rows = csv.writer(out, lineterminator="\n")
        rows.writerow([column.head for column in self.columns])
        for row in self.rows:
            rows.writerow(["" if _missing(cell) else cell for cell in row])
        return out.getvalue()

    def shown(self) -> list[list[tuple[str, str]]]:
        """Rows of (text, CSS class)."""
        return [
            [_shown(cell, column) for cell, column in zip(row, self.columns, strict=True)]
            for row in self.rows
        ]

    @property
    def kinds(self) -> list[str]:
        """CSS class of each column: num where it holds nothing but numbers and dashes."""
        shown = self.shown()
        return [
            "num" if all(row[place][1] == "num" for row in shown) else "text"
            for place in range(len(self.columns))
        ]


def _missing(cell: Cell) -> bool:
    return cell is None or (isinstance(cell, float) and not math.isfinite(cell))


def _shown(cell: Cell, column: Column) -> tuple[str, str]:
    if isinstance(cell, str):
        return cell, "num" if _number(cell) else "text"
    if cell is None or _missing(cell):
        return "\N{EN DASH}", "num"
    text = format(cell, column.form)
    if float(text) == 0.0:
        text = text.lstrip("+-")  # a difference that rounds to nothing has no sign
    return text, "num"


def _number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def percent(share: float, digits: int = 0, sign: str = "") -> str:
    """A share as text, with a space before the sign as everywhere here."""
    return f"{100.0 * share:{sign}.{digits}f} %"


def difference(value: float | None, paper: float | None) -> float | None:
    """Value over the paper's, less 1, in percent; None where there is no such thing."""
    if value is None or paper is None or not math.isfinite(value) or paper == 0.0:
        return None
    return 100.0 * (value / paper - 1.0)


PERCENT = "+.1f"
