"""`ecyl diagnose`: where the gap between a recording and its model lies, and what causes it."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

from .diagnose_each import add_each, refuse_alone, run_each
from .judge import judge_of
from .outputs import add_overwrite, check_outputs
from .progress import progress_bar
from .recording_options import add_recording, add_span, read_map, read_span


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the verb's flags."""
    add_recording(parser, "recording")
    add_span(parser)
    parser.add_argument(
        "--drive",
        required=True,
        metavar="DRIVE.yaml",
        help="nominal model: a drive file, or a profile: paper, si, bench, servo_1khz",
    )
    parser.add_argument(
        "--mode",
        type=float,
        metavar="VALUE",
        help="judge only samples whose mapped `mode` has this value (rigid drives, followers)",
    )
    parser.add_argument("--json", type=Path, metavar="OUT", help="write the diagnosis as JSON")
    parser.add_argument(
        "--report", type=Path, metavar="OUT.html", help="write the diagnosis as one HTML page"
    )
    parser.add_argument(
        "--write-drive",
        type=Path,
        metavar="OUT.yaml",
        help="write the drive file with the constants found and the causes added, for ecyl run or "
        "ecyl diagnose --drive",
    )
    parser.add_argument(
        "--write-mcap",
        type=Path,
        metavar="OUT.mcap",
        help="write recorded and simulated signals, residuals and events, to scrub through",
    )
    add_overwrite(parser)
    add_each(parser)


def run(options: argparse.Namespace) -> int:
    """Diagnose, write what was asked for, print the summary; 0 whatever the verdict."""
    from ..drive.drive_file import resolve_drive

    drive_file = resolve_drive(options.drive)
    if options.each:
        return run_each(options, drive_file)
    refuse_alone(options)
    check_outputs(
        {
            "--json": options.json,
            "--report": options.report,
            "--write-drive": options.write_drive,
            "--write-mcap": options.write_mcap,
        },
        {"RECORDING": options.recording, "--drive": drive_file, "--map": options.map},
        overwrite=options.overwrite,
        suffixes={"--write-mcap": ".mcap"},
    )
    judge = judge_of(options, drive_file)
    read_span(options)  # refused before anything is read
    signal_map = read_map(options)

    from ..gap.plain import finite
    from ..gap.report.page import write_report
    from ..gap.report.scrub import write_scrub
    from ..gap.report.terminal import summary
    from ..gap.twin import write_twin
    from ..recording.atomic import write_text

    with progress_bar("diagnosing") as progress:
        diagnosis = judge(signal_map, progress)
    written = []
    if options.json is not None:
        data = finite(diagnosis.as_json())
        write_text(options.json, json.dumps(data, indent=2, allow_nan=False) + "\n")
        written.append(str(options.json))
    if options.report is not None:
        write_report(diagnosis, options.report)
        written.append(str(options.report))
    if options.write_mcap is not None:
        write_scrub(diagnosis, options.write_mcap)
        written.append(str(options.write_mcap))
    if options.write_drive is not None and diagnosis.closes:
        write_twin(diagnosis, drive_file, options.write_drive)
        written.append(str(options.write_drive))
    print(summary(diagnosis, written))
    if options.write_drive is not None and not diagnosis.closes:
        print(
            f"ecyl diagnose: no cause was named, {options.write_drive} is not written",
            file=sys.stderr,
        )
    return 0
