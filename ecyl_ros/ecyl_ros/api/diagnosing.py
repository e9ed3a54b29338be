"""One diagnosis, from a file or a recording in memory, of whatever kind of drive."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Callable, Collection, Sequence
from pathlib import Path

from ..drive.drive_file import resolve_drive
from ..drive.model_file import load_model
from ..drive.parameters import DriveParameters
from ..drive.rigid.machine import Machine
from ..errors import InputError
from ..gap.diagnose import diagnose as judge
from ..gap.diagnosis import Diagnosis
from ..gap.listed import listed
from ..gap.long_run import MOST_STRETCHES, diagnose_long
from ..gap.replay.screen import LONGEST_S
from ..gap.several.together import check_together, diagnose_together
from ..recording.load import LongRecording, load_long, load_stretch, long_or_whole
from ..recording.map import SignalMap
from ..recording.signals import Recording
from ..recording.signs import wrong_signs
from ..recording.span import Span
from .reading import PathName, as_map, as_span
from .result import DiagnosisResult

Progress = Callable[[float], None]

_LOOKED_THROUGH = 0.2  # share of the work, where a long recording is looked through first


def diagnose(
    recording: Recording | PathName | Sequence[Recording | PathName],
    drive: DriveParameters | Machine | PathName,
    signal_map: SignalMap | PathName | None = None,
    *,
    begin_s: float | None = None,
    end_s: float | None = None,
    mode: float | None = None,
    without: Collection[str] = (),
    progress: Progress | None = None,
) -> DiagnosisResult:
    """Where the gap between a recording and its model lies, what causes it, how far it shrinks.

    Args:
        recording: of the real drive; or its file, of which as much is read as is judged, so that
            hours of it fit. A list of recordings of one machine is diagnosed together: one set of
            causes and one sheet, held out by recording, too.
        drive: the nominal model: a drive file, a profile (`paper`, `si`, `bench`, `servo_1khz`),
            or what `load_drive` gave.
        signal_map, begin_s, end_s: of a file, as `read` takes them.
        mode: judge only the samples whose mapped `mode` has this value (rigid drives, followers).
        without: effects of the catalogue that the machine surely has not: they do not compete.
        progress: called now and then with the share done, 0 to 1.

    Raises:
        InputError: unusable input: nothing to compare, too short, no motion, an unstable loop, an
            effect in `without` that does not exist.
    """
    tell = progress or (lambda share: None)
    drive_file: Path | None = None
    if isinstance(drive, DriveParameters | Machine):
        model, name = drive, "drive"
    else:
        drive_file = resolve_drive(drive)
        model, name = load_model(drive_file), str(drive_file)
    span = as_span(begin_s, end_s)
    if not isinstance(recording, Recording | str | os.PathLike):
        found = _together(recording, model, name, as_map(signal_map), span, mode, without, tell)
        return DiagnosisResult.of(_doing_without(found, without), drive_file)
    if isinstance(recording, Recording):
        source = "recording"
        if signal_map is not None:
            raise InputError("signal_map is for a file; this recording is read already")
        part = recording if span is None else span.part(recording, source)
        whole = _in_memory(part, model)
    else:
        source = os.fspath(recording)
        whole = _from_file(Path(recording), as_map(signal_map), span, model, tell)
        tell = _rest_of(tell)
    if isinstance(whole, LongRecording):
        if mode is not None:
            raise InputError(f"{name}: a full cylinder is judged in all modes; expected no mode")
        assert isinstance(model, DriveParameters)
        found = diagnose_long(
            whole, model, without=without, source=source, drive_name=name, progress=tell
        )
    else:
        found = judge(
            whole,
            model,
            without=without,
            mode=mode,
            source=source,
            drive_name=name,
            progress=tell,
        )
        found = _with_notes(found, whole, source)
    return DiagnosisResult.of(_doing_without(found, without), drive_file)


def _doing_without(diagnosis: Diagnosis, without: Collection[str]) -> Diagnosis:
    """The diagnosis, which says what did not compete."""
    if not without:
        return diagnosis
    note = f"as asked, the diagnosis did without {listed(list(without))}"
    return dataclasses.replace(diagnosis, notes=(note, *diagnosis.notes))


def _together(
    recordings: Sequence[Recording | PathName],
    model: DriveParameters | Machine,
    name: str,
    signal_map: SignalMap | None,
    span: Span | None,
    mode: float | None,
    without: Collection[str],
    tell: Progress,
) -> Diagnosis:
    """Of several recordings of one machine."""
    if len(recordings) < 2:
        raise InputError(f"{len(recordings)} recordings in a list, expected two or more")
    paths = [os.fspath(one) for one in recordings if not isinstance(one, Recording)]
    places = [os.path.realpath(one) for one in paths]
    for path, place in zip(paths, places, strict=True):
        if places.count(place) > 1:
            raise InputError(f"{path}: given twice; expected different recordings of one machine")
    check_together(model, mode, name)
    read, sources = [], []
    for number, one in enumerate(recordings, start=1):
        if isinstance(one, Recording):
            source = f"recording {number}"
            read.append(one if span is None else span.part(one, source))
        else:
            source = os.fspath(one)
            read.append(load_stretch(Path(one), signal_map, LONGEST_S, span=span))
        sources.append(source)
        tell(_LOOKED_THROUGH * number / len(recordings))
    found = diagnose_together(
        read,
        model,
        without=without,
        mode=mode,
        sources=sources,
        drive_name=name,
        progress=_rest_of(tell),
    )
    notes, signs = list[str](), list[str]()
    for whole, source in zip(read, sources, strict=True):
        notes += [f"{source}: {note.removeprefix(f'{source}: ')}" for note in whole.notes]
        signs += [f"{source}: {one.text}" for one in wrong_signs(whole)]
    return _cautioned(found, notes, signs)


def _rest_of(tell: Progress) -> Progress:
    """Progress of what comes after a recording was looked through."""
    return lambda share: tell(_LOOKED_THROUGH + (1.0 - _LOOKED_THROUGH) * share)


def _in_memory(recording: Recording, model: DriveParameters | Machine) -> Recording | LongRecording:
    if isinstance(model, DriveParameters):
        return long_or_whole(recording, "recording", LONGEST_S, MOST_STRETCHES)
    return recording


def _from_file(
    path: Path,
    signal_map: SignalMap | None,
    span: Span | None,
    model: DriveParameters | Machine,
    tell: Progress,
) -> Recording | LongRecording:
    def looked(share: float) -> None:
        tell(_LOOKED_THROUGH * share)

    if isinstance(model, DriveParameters):
        return load_long(path, signal_map, LONGEST_S, MOST_STRETCHES, looked, span)
    return load_stretch(path, signal_map, LONGEST_S, looked, span)


def _with_notes(diagnosis: Diagnosis, recording: Recording, source: str) -> Diagnosis:
    """What was missing or cut off when the recording was read limits what could be judged."""
    notes = [note.removeprefix(f"{source}: ") for note in recording.notes]
    return _cautioned(diagnosis, notes, [one.text for one in wrong_signs(recording)])


def _cautioned(diagnosis: Diagnosis, notes: Sequence[str], signs: Sequence[str]) -> Diagnosis:
    """With what was noted as the recording was read, and signs that are wrong before all else."""
    cautions = [*signs, diagnosis.caution] if diagnosis.caution else signs
    return dataclasses.replace(
        diagnosis, notes=(*notes, *diagnosis.notes), caution="; ".join(cautions)
    )
