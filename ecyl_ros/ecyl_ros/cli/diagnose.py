"""`ecyl diagnose`: where the gap between a recording and its model lies, and what causes it."""

from __future__ import annotations

import argparse
import dataclasses
import functools
import json
import math
import sys
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import InputError
from .outputs import add_overwrite, check_outputs
from .progress import progress_bar
from .recording_options import add_recording, add_span, read_map, read_span

if TYPE_CHECKING:  # not at run time, to keep `--help` fast
    from ..drive.parameters import DriveParameters
    from ..drive.rigid.machine import Machine
    from ..gap.diagnosis import Diagnosis
    from ..recording.map import SignalMap
    from ..recording.signals import Recording

    Judge = Callable[[SignalMap | None, Callable[[float], None]], Diagnosis]


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


def run(options: argparse.Namespace) -> int:
    """Diagnose, write what was asked for, print the summary; 0 whatever the verdict."""
    from ..drive.drive_file import resolve_drive

    drive_file = resolve_drive(options.drive)
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
    judge = _judge(options, drive_file)
    read_span(options)  # refused before anything is read
    signal_map = read_map(options)

    from ..gap.report.page import write_report
    from ..gap.report.scrub import write_scrub
    from ..gap.report.terminal import summary
    from ..gap.twin import write_twin
    from ..recording.atomic import write_text

    with progress_bar("diagnosing") as progress:
        diagnosis = judge(signal_map, progress)
    written = []
    if options.json is not None:
        data = _finite(diagnosis.as_json())
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


_LOOKED_THROUGH = 0.2  # share of the work, where a long recording is looked through first


def _judge(options: argparse.Namespace, drive_file: Path) -> Judge:
    """What reads and diagnoses the recording, for the kind of drive that the file describes."""
    from ..drive.model_file import load_model
    from ..drive.parameters import DriveParameters

    drive = load_model(drive_file)
    if isinstance(drive, DriveParameters):
        if options.mode is not None:
            raise InputError(
                f"--mode {options.mode:g}: {drive_file} describes a full cylinder; expected a "
                "drive file with drive.kind, see docs/drive-file.md"
            )
        return functools.partial(_by_replay, options, drive, str(drive_file))
    if options.write_drive is not None and drive.kind == "follower":
        raise InputError(
            f"--write-drive {options.write_drive}: not for a drive of kind follower; what is known "
            "of it is in the JSON and the report, under what was measured"
        )
    return functools.partial(_by_motion, options, drive, str(drive_file))


def _by_replay(
    options: argparse.Namespace,
    drive: DriveParameters,
    drive_name: str,
    signal_map: SignalMap | None,
    progress: Callable[[float], None],
) -> Diagnosis:
    from ..gap.diagnose import diagnose
    from ..gap.long_run import MOST_STRETCHES, diagnose_long
    from ..gap.screen import LONGEST_S
    from ..recording.load import LongRecording, load_long

    source = str(options.recording)
    found = load_long(
        options.recording,
        signal_map,
        LONGEST_S,
        MOST_STRETCHES,
        lambda share: progress(_LOOKED_THROUGH * share),
        read_span(options),
    )
    if isinstance(found, LongRecording):
        return diagnose_long(
            found,
            drive,
            source=source,
            drive_name=drive_name,
            progress=lambda share: progress(_LOOKED_THROUGH + (1.0 - _LOOKED_THROUGH) * share),
        )
    diagnosis = diagnose(found, drive, source=source, drive_name=drive_name, progress=progress)
    return _with_notes(diagnosis, found, source)


def _by_motion(
    options: argparse.Namespace,
    machine: Machine,
    drive_name: str,
    signal_map: SignalMap | None,
    progress: Callable[[float], None],
) -> Diagnosis:
    from ..gap.diagnose import diagnose
    from ..gap.screen import LONGEST_S
    from ..recording.load import load_stretch

    source = str(options.recording)
    recording = load_stretch(
        options.recording,
        signal_map,
        LONGEST_S,
        lambda share: progress(_LOOKED_THROUGH * share),
        read_span(options),
    )
    diagnosis = diagnose(
        recording,
        machine,
        mode=options.mode,
        source=source,
        drive_name=drive_name,
        progress=progress,
    )
    return _with_notes(diagnosis, recording, source)


def _with_notes(diagnosis: Diagnosis, recording: Recording, source: str) -> Diagnosis:
    """What was missing or cut off when the recording was read limits what could be judged."""
    from ..recording.signs import wrong_signs

    notes = [note.removeprefix(f"{source}: ") for note in recording.notes]
    caution = "; ".join(one.text for one in wrong_signs(recording))
    return dataclasses.replace(diagnosis, notes=(*notes, *diagnosis.notes), caution=caution)


def _finite(data: Any) -> Any:
    """Plain data with None for numbers that JSON does not know."""
    if isinstance(data, dict):
        return {key: _finite(value) for key, value in data.items()}
    if isinstance(data, str):
        return data
    if isinstance(data, float):
        return data if math.isfinite(data) else None
    return [_finite(value) for value in data] if isinstance(data, Iterable) else data
