"""How every benchmark prints its figures and, with `--json FILE`, stores them."""

from __future__ import annotations

import argparse
import json
import os
import platform
import statistics
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]


def parser(description: str | None) -> argparse.ArgumentParser:
    """A parser with the one flag that all benchmarks share."""
    made = argparse.ArgumentParser(description=description)
    made.add_argument("--json", type=Path, metavar="FILE", help="write the figures here too")
    return made


def wall_time_s(work: Callable[[], Any]) -> float:
    """Wall time of one call, s."""
    begin = time.perf_counter()
    work()
    return time.perf_counter() - begin


def median_wall_time_s(work: Callable[[], Any], runs: int) -> float:
    """Median wall time over `runs` calls, s."""
    return statistics.median(wall_time_s(work) for _ in range(runs))


class Report:
    """Sections, tables and lines on stdout; named figures for the JSON file."""

    def __init__(self, title: str) -> None:
        load = os.getloadavg()[0]
        self.figures: dict[str, Any] = {
            "python": platform.python_version(),
            "cores": os.cpu_count(),
            "load_at_start": load,
        }
        print(f"== {title}")
        print(f"   Python {platform.python_version()}, {os.cpu_count()} cores, load {load:.1f}")

    def say(self, text: str) -> None:
        """One line of plain text."""
        print(text, flush=True)

    def table(self, header: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
        """A table with the first column left and the others right aligned."""
        widths = [max(len(row[column]) for row in (header, *rows)) for column in range(len(header))]
        for row in (header, *rows):
            cells = [row[0].ljust(widths[0])]
            cells += [cell.rjust(width) for cell, width in zip(row[1:], widths[1:], strict=True)]
            print("  " + "  ".join(cells).rstrip())
        print(flush=True)

    def target(self, key: str, value: float, form: str, wanted: str, meaning: str) -> None:
        """A figure beside the target it is meant to reach; nothing is asserted."""
        self.figures[key] = value
        print(f"  {meaning}: {value:{form}}   (target {wanted})", flush=True)

    def finish(self, path: Path | None) -> None:
        """Write the figures if a file was asked for."""
        print(flush=True)
        if path is not None:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(json.dumps(self.figures, indent=2) + "\n", encoding="utf-8")
            print(f"figures in {path}", file=sys.stderr)
