"""Reads and diagnoses a recording as `ecyl diagnose` is asked to, by the kind of its drive."""

from __future__ import annotations

import argparse
import dataclasses
import functools
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import InputError
from .recording_options import read_span

if TYPE_CHECKING:  # not at run time, to keep `--help` fast
    from ..drive.parameters import DriveParameters
    from ..drive.rigid.machine import Machine
    from ..gap.diagnosis import Diagnosis
    from ..recording.map import SignalMap
    from ..recording.signals import Recording

    Judge = Callable[[SignalMap | None, Callable[[float], None]], Diagnosis]

_LOOKED_THROUGH = 0.2  # share of the work, where a long recording is looked through first


def judge_of(options: argparse.Namespace, drive_file: Path) -> Judge:
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
