"""`diagnose_together`: recordings of one machine in, one set of causes and one sheet out."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable, Collection, Sequence
from typing import Any

from ...analysis.one_thread import on_one_thread
from ...drive.parameters import DriveParameters
from ...drive.rigid.machine import Machine
from ...errors import InputError
from ...recording.signals import Recording
from ..diagnose import check_input, check_no_mode
from ..diagnosis import Diagnosis
from .checks import check_different
from .cylinder import diagnose_cylinders
from .rigid import diagnose_rigid_together


def check_together(drive: DriveParameters | Machine, mode: float | None, drive_name: str) -> None:
    """Raise InputError for a kind of drive that is judged one recording at a time, or its mode."""
    if isinstance(drive, DriveParameters):
        check_no_mode(mode, drive_name)
    elif drive.kind == "follower":
        raise InputError(
            f"{drive_name}: a follower is judged one recording at a time; expected a full cylinder "
            "or a drive of kind rigid for several recordings together, or --each and a folder"
        )


@on_one_thread
def diagnose_together(
    recordings: Sequence[Recording],
    drive: DriveParameters | Machine,
    *,
    without: Collection[str] = (),
    mode: float | None = None,
    sources: Sequence[str],
    drive_name: str = "drive",
    progress: Callable[[float], None] | None = None,
) -> Diagnosis:
    """Diagnose the gap between several recordings of one machine and the nominal model.

    Args:
        recordings: two or more, of the real drive; each with its own start and noise.
        drive: the nominal model, as far as it is known.
        without: effects that the diagnosis must do without.
        mode: judge only the samples whose recorded mode has this value.
        sources: what messages call the recordings. drive_name: and the drive.
        progress: called now and then with the share done, 0 to 1.

    Raises:
        InputError: as `diagnose` does; fewer than two recordings, a signal that one lacks,
            two copies of one recording, recordings of different machines, a kind of drive that is
            judged one at a time.
    """
    begin = time.perf_counter()
    tell = progress or (lambda share: None)
    check_together(drive, mode, drive_name)
    if len(recordings) < 2:
        raise InputError(
            f"{', '.join(sources) or drive_name}: expected two or more recordings to diagnose "
            "together; `diagnose` takes one"
        )
    for one, source in zip(recordings, sources, strict=True):
        check_input(one, drive, without, source, together=True)
    check_different(recordings, sources)
    named: dict[str, Any] = {"sources": sources, "drive_name": drive_name, "tell": tell}
    if isinstance(drive, DriveParameters):
        result = diagnose_cylinders(recordings, drive, without=without, **named)
    else:
        result = diagnose_rigid_together(recordings, drive, without=without, mode=mode, **named)
    tell(1.0)
    return dataclasses.replace(result, seconds=time.perf_counter() - begin)
