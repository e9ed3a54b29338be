"""`ecyl mend BAG --out NEW.mcap`: close a recording whose recorder was killed."""

from __future__ import annotations

import argparse
from pathlib import Path

from .outputs import add_overwrite, check_outputs


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the verb's flags."""
    parser.add_argument(
        "bag", type=Path, metavar="BAG", help="MCAP file, or rosbag2 folder of them"
    )
    parser.add_argument(
        "--out", type=Path, required=True, metavar="NEW.mcap", help="closed recording to write"
    )
    add_overwrite(parser)


def run(options: argparse.Namespace) -> int:
    """Rewrite every whole message with an index, and say what was wrong."""
    from ..recording.mend import mend

    check_outputs(
        {"--out": options.out},
        {"BAG": options.bag},
        overwrite=options.overwrite,
        suffixes={"--out": ".mcap"},
    )
    count, notes = mend(options.bag, options.out)
    for note in notes or (f"{options.bag}: nothing was missing",):
        print(note)
    print(f"{count} messages in {options.out}")
    return 0
