"""The recording that `analyse` and `diagnose` read, and the map of a foreign one."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # not at run time, to keep `--help` fast
    from ..recording.map import SignalMap


def add_recording(parser: argparse.ArgumentParser, name: str) -> None:
    """Declare the positional argument `name` and `--map`."""
    parser.add_argument(
        name,
        type=Path,
        metavar=name.upper(),
        help="MCAP, sqlite3, CSV or MAT file, or rosbag2 folder",
    )
    parser.add_argument(
        "--map",
        type=Path,
        metavar="M.yaml",
        help="which field of a foreign recording is which signal (ecyl inspect proposes one)",
    )


def read_map(options: argparse.Namespace) -> SignalMap | None:
    """The map that `--map` names; None without one."""
    from ..recording.map import load_map

    return None if options.map is None else load_map(options.map)
