"""The tables that answer the paper, as text."""

from __future__ import annotations

from collections.abc import Sequence
from typing import IO

from .tables import Table

PRINTED = ("table3", "elasticity", "fig12_imf1", "fig14_imf2", "table1", "clearance_stiffness")


def print_tables(tables: Sequence[Table], file: IO[str] | None = None) -> None:
    """Print those in `PRINTED`; all are in the folder."""
    from rich.console import Console
    from rich.table import Table as Rich

    console = Console(file=file, highlight=False)
    if not console.is_terminal:
        console = Console(file=file, highlight=False, width=180, color_system=None)
    by_name = {table.name: table for table in tables}
    for name in PRINTED:
        table = by_name[name]
        shown = Rich(
            *(column.head for column in table.columns),
            box=None,
            title=table.title,
            title_justify="left",
        )
        for place, column in enumerate(shown.columns):
            column.justify = "left" if place == 0 else "right"
        for row in table.shown():
            shown.add_row(*(text.replace("\N{EN DASH}", "-") for text, _ in row))
        console.print(shown)
        console.print()
