"""`ecyl paper OUT_DIR`: the paper's tables and figures, simulated in both readings."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from ..errors import InputError
from .progress import progress_bar


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Flags of `ecyl paper`."""
    parser.add_argument(
        "out", type=Path, metavar="OUT_DIR", help="folder for index.html, tables/ and figures/"
    )
    parser.add_argument(
        "--starts",
        type=int,
        default=5,
        metavar="N",
        help="starting states per value, 1 to 8 (5): the spread of what they give is shown",
    )
    parser.add_argument(
        "--draws", type=int, default=200, metavar="N", help="of the bench's sensor errors (200)"
    )
    parser.add_argument("--jobs", type=int, metavar="J", help="processes (one per core)")


def run(options: argparse.Namespace) -> int:
    """Run everything, write, print the tables that answer the paper."""
    from ..analysis.parallel import WorkerError
    from ..paper.reproduce import results_of, write
    from ..paper.terminal import print_tables

    if options.jobs is not None and options.jobs < 1:
        raise InputError(f"--jobs = {options.jobs}, expected 1 or more")
    if options.draws < 2:
        raise InputError(f"--draws = {options.draws}, expected 2 or more")
    try:
        options.out.mkdir(parents=True, exist_ok=True)  # a minute of work needs a place to go
    except OSError as error:
        raise InputError(f"{options.out}: no folder: {error.strerror}") from None
    try:
        with progress_bar("simulating") as progress:
            results = results_of(options.starts, jobs=options.jobs, progress=progress)
        tables = write(results, options.out, draws=options.draws, jobs=options.jobs)
    except WorkerError as error:
        print(f"ecyl paper: {error}", file=sys.stderr)
        return 1
    print_tables(tables)
    print(f"page  {options.out / 'index.html'}")
    return 0
