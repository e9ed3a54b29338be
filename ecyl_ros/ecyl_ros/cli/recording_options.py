"""The recording that `analyse` and `diagnose` read, and the map of a foreign one."""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # not at run time, to keep `--help` fast
    from ..recording.map import SignalMap
    from ..recording.span import Span


def add_recording(parser: argparse.ArgumentParser, name: str, *, several: bool = False) -> None:
    """Declare the positional argument `name` and `--map`; several: one or more of it, a list."""
    parser.add_argument(
        name,
        type=Path,
        metavar=name.upper(),
        nargs="+" if several else None,
        help="MCAP, sqlite3, CSV or MAT file, or rosbag2 folder"
        + ("; several of one machine are diagnosed together" if several else ""),
    )
    parser.add_argument(
        "--map",
        type=Path,
        metavar="M.yaml",
        help="which field of a foreign recording is which signal (ecyl inspect proposes one)",
    )


def add_span(parser: argparse.ArgumentParser) -> None:
    """Declare `--from` and `--to`."""
    for flag, dest, what in (
        ("--from", "begin_s", "leave out what lies before S"),
        ("--to", "end_s", "leave out what lies from S on"),
    ):
        parser.add_argument(
            flag,
            dest=dest,
            type=float,
            metavar="S",
            help=f"{what} (seconds from the first stamp)",
        )


def read_span(options: argparse.Namespace) -> Span | None:
    """The part that `--from` and `--to` name; None without either.

    Raises:
        InputError: negative, reversed or empty.
    """
    from ..recording.span import Span

    if options.begin_s is None and options.end_s is None:
        return None
    begin = 0.0 if options.begin_s is None else options.begin_s
    return Span(begin, math.inf if options.end_s is None else options.end_s)


def read_map(options: argparse.Namespace) -> SignalMap | None:
    """The map that `--map` names; None without one."""
    from ..recording.map_file import load_map

    return None if options.map is None else load_map(options.map)
