"""`diagnose`: a recording and a nominal drive in, where the gap lies, what causes it, how far it
shrinks out.

Each kind of drive is judged by what is known of it: a full cylinder by replay in closed loop, a
rigid drive by the effort that its motion needs, a follower by how it follows.
"""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable, Collection, Mapping
from typing import Any

from ..analysis.one_thread import on_one_thread
from ..drive.parameters import DriveParameters
from ..drive.rigid.machine import Machine
from ..effects.catalogue import CATALOGUE, rigid_forms
from ..errors import InputError
from ..recording.signals import Recording
from .cylinder import diagnose_cylinder
from .diagnosis import Diagnosis
from .follower import diagnose_follower
from .rigid.diagnose import diagnose_rigid

_SHORTEST_S, _SHORTEST_RIGID_S = 1.5, 3.0


def effects_of(drive: DriveParameters | Machine) -> Mapping[str, Any]:
    """The effects, by name, that compete for the gap of a drive of this kind."""
    if isinstance(drive, DriveParameters):
        return CATALOGUE
    return {} if drive.kind == "follower" else rigid_forms(drive.linear)


def check_input(
    recording: Recording,
    drive: DriveParameters | Machine,
    without: Collection[str],
    source: str,
    together: bool = False,
) -> None:
    """Raise InputError for an effect in `without` that does not exist, or too short a recording.

    together: with others of the same machine, which hold the rest of what is needed.
    """
    known = effects_of(drive)
    unknown = sorted(set(without) - set(known))
    if unknown:
        raise InputError(
            f"without {unknown[0]}: no such effect competes; expected one of {', '.join(known)}"
        )
    rigid_alone = not (isinstance(drive, DriveParameters) or together)
    shortest = _SHORTEST_RIGID_S if rigid_alone else _SHORTEST_S
    # The last sample counts for a period, too: 3000 samples at 1 kHz are 3 s.
    samples = len(recording)
    long_s = recording.duration_s * samples / (samples - 1) if samples > 1 else 0.0
    if samples and long_s < shortest * (1.0 - 1e-6):
        raise InputError(
            f"{source}: {long_s:.4g} s long, expected at least {shortest:g} s to "
            "fit on one part and judge on another"
        )


def check_no_mode(mode: float | None, drive_name: str) -> None:
    """Raise InputError where a full cylinder's recording is to be judged in one mode alone."""
    if mode is not None:
        raise InputError(
            f"{drive_name}: a full cylinder is judged in all modes; expected no mode ({mode:g})"
        )


@on_one_thread
def diagnose(
    recording: Recording,
    drive: DriveParameters | Machine,
    *,
    without: Collection[str] = (),
    mode: float | None = None,
    source: str = "recording",
    drive_name: str = "drive",
    progress: Callable[[float], None] | None = None,
) -> Diagnosis:
    """Diagnose the gap between a recording and the nominal model.

    Args:
        recording: of the real drive.
        drive: the nominal model, as far as it is known.
        without: effects that the diagnosis must do without.
        mode: judge only the samples whose recorded mode has this value (rigid drives, followers).
        source, drive_name: what messages call the two.
        progress: called now and then with the share done, 0 to 1.

    Raises:
        InputError: unusable input: nothing to compare, too short, no motion, no such mode, an
            unstable loop, an effect in `without` that does not exist.
    """
    begin = time.perf_counter()
    check_input(recording, drive, without, source)
    tell = progress or (lambda share: None)
    named: dict[str, Any] = {"source": source, "drive_name": drive_name, "tell": tell}
    if isinstance(drive, DriveParameters):
        check_no_mode(mode, drive_name)
        result = diagnose_cylinder(recording, drive, without=without, **named)
    elif drive.kind == "follower":
        result = diagnose_follower(recording, drive, mode=mode, **named)
    else:
        result = diagnose_rigid(recording, drive, without=without, mode=mode, **named)
    tell(1.0)
    return dataclasses.replace(result, seconds=time.perf_counter() - begin)
