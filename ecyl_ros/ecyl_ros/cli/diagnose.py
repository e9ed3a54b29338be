"""`ecyl diagnose`: where the gap between a recording and its model lies, and what causes it."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from ..errors import InputError
from .diagnose_each import add_each, refuse_alone, run_each
from .drive_kind import check_kind
from .outputs import add_overwrite, check_outputs
from .progress import progress_bar
from .recording_options import add_recording, add_span, read_map, read_span
from .without import add_without, without_of


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the verb's flags."""
    add_recording(parser, "recording", several=True)
    add_span(parser)
    parser.add_argument(
        "--drive",
        required=True,
        metavar="DRIVE.yaml",
        help="nominal model: a drive file, or a profile: paper, si, bench, servo_1khz, worn_1khz",
    )
    parser.add_argument(
        "--mode",
        type=float,
        metavar="VALUE",
        help="judge only samples whose mapped `mode` has this value (rigid drives, followers)",
    )
    add_without(parser)
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
    recordings: list[Path] = options.recording
    several = len(recordings) > 1
    if several and options.write_mcap is not None:
        raise InputError("--write-mcap is for one recording; expected --report or --json instead")
    inputs = {f"RECORDING {one}": one for one in recordings}
    check_outputs(
        {
            "--json": options.json,
            "--report": options.report,
            "--write-drive": options.write_drive,
            "--write-mcap": options.write_mcap,
        },
        {**inputs, "--drive": drive_file, "--map": options.map},
        overwrite=options.overwrite,
        suffixes={"--write-mcap": ".mcap"},
    )
    check_kind(options, drive_file)
    read_span(options)  # refused before anything is read
    signal_map = read_map(options)

    from ..api.diagnosing import diagnose
    from ..gap.report.terminal import summary

    with progress_bar("diagnosing") as progress:
        diagnosis = diagnose(
            recordings if several else recordings[0],
            drive_file,
            signal_map,
            begin_s=options.begin_s,
            end_s=options.end_s,
            mode=options.mode,
            without=without_of(options),
            progress=progress,
        )
    writers = (
        (options.json, diagnosis.write_json),
        (options.report, diagnosis.write_report),
        (options.write_mcap, diagnosis.write_mcap),
        (options.write_drive if diagnosis.has_twin else None, diagnosis.write_drive),
    )
    written = []
    for path, write in writers:
        if path is not None:
            write(path)
            written.append(str(path))
    print(summary(diagnosis, written))
    if options.write_drive is not None and not diagnosis.has_twin:
        why = "no cause was named" if diagnosis.law is None else "no drive file holds this law"
        print(
            f"ecyl diagnose: {why}, {options.write_drive} is not written",
            file=sys.stderr,
        )
    return 0
