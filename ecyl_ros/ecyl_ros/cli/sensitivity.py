"""`ecyl sensitivity`: how tracking changes with one or two parameters of a drive file."""

from __future__ import annotations

import argparse
import math
import sys
from pathlib import Path

from ..errors import InputError
from .outputs import check_outputs
from .progress import progress_bar


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Flags of `ecyl sensitivity`."""
    parser.add_argument(
        "--drive", required=True, metavar="D.yaml", help="nominal drive file or profile"
    )
    parser.add_argument(
        "--vary",
        required=True,
        action="append",
        metavar="NAME=F1,F2",
        help="a key of the drive file (or its end, where unique) and multiples of its value; "
        "NAME:=V1,V2 for values in SI; START:STOP:COUNT for evenly spaced ones; "
        "twice for a grid",
    )
    parser.add_argument(
        "--reference",
        default="sine:amplitude=2e-5,frequency=1",
        metavar="SPEC",
        help="as in ecyl run (the paper's sine:amplitude=2e-5,frequency=1)",
    )
    parser.add_argument(
        "--duration", type=float, default=20.0, metavar="S", help="seconds to run (20)"
    )
    parser.add_argument(
        "--skip", type=float, metavar="S", help="seconds not judged at the start (half of them)"
    )
    parser.add_argument("--jobs", type=int, metavar="J", help="processes (one per core)")
    parser.add_argument(
        "--dask", metavar="ADDRESS", help="run on the Dask cluster of this scheduler instead"
    )
    parser.add_argument("--json", type=Path, metavar="OUT", help="write all figures as JSON")
    parser.add_argument("--csv", type=Path, metavar="OUT", help="write a line per run as CSV")
    parser.add_argument("--plots", type=Path, metavar="DIR", help="write sensitivity.png")


def run(options: argparse.Namespace) -> int:
    """Sweep, print; 1 where no drive of the sweep could run or a worker was lost."""
    from ..analysis.parallel import WorkerError
    from ..analysis.sensitivity import report
    from ..analysis.sensitivity.sweep import Experiment, sweep
    from ..analysis.sensitivity.vary import parse_axis, points
    from ..drive.drive_file import load_drive, resolve_drive

    skip = _checked_skip(options)
    if options.jobs is not None and options.jobs < 1:
        raise InputError(f"--jobs = {options.jobs}, expected 1 or more")
    if len(options.vary) > 2:
        raise InputError(f"--vary is given {len(options.vary)} times, expected one or two")
    check_outputs(
        {"--json": options.json, "--csv": options.csv},
        {"--drive": resolve_drive(options.drive)},
        overwrite=True,
    )
    drive = load_drive(options.drive)
    axes = [parse_axis(text, drive) for text in options.vary]
    drives = points(drive, axes, options.drive)
    experiment = Experiment(options.reference, options.duration, skip)
    try:
        with progress_bar(f"{len(drives)} runs") as progress:
            outcomes = sweep(
                drives,
                experiment,
                options.drive,
                jobs=options.jobs,
                dask=options.dask,
                progress=progress,
            )
    except WorkerError as error:
        print(f"ecyl sensitivity: {error}", file=sys.stderr)
        return 1
    if all(one.figures is None for one in outcomes):
        raise InputError(str(outcomes[0].error))
    if options.json is not None:
        data = report.as_json(options.drive, experiment, axes, drives, outcomes)
        report.write_json(data, options.json)
    if options.csv is not None:
        report.write_csv(axes, drives, outcomes, options.csv)
    if options.plots is not None:
        from ..analysis.sensitivity.plot import write_plot

        write_plot(axes, drives, outcomes, options.plots)
    report.print_table(axes, drives, outcomes)
    return 0


def _checked_skip(options: argparse.Namespace) -> float:
    if not (math.isfinite(options.duration) and options.duration > 0.0):
        raise InputError(f"--duration = {options.duration:g}, expected more than 0 s")
    skip = 0.5 * options.duration if options.skip is None else options.skip
    if not 0.0 <= skip < options.duration:
        raise InputError(f"--skip = {skip:g}, expected 0 to less than {options.duration:g} s")
    return float(skip)
