"""A run of the emulated drive, as a recording."""

from __future__ import annotations

import math
import os
from collections.abc import Callable

from ..drive.drive_file import load_drive
from ..drive.engine import simulate as run
from ..drive.parameters import DriveParameters
from ..drive.reference.base import Reference
from ..drive.reference.recorded import Recorded
from ..drive.reference.setpoint import SetpointFollower
from ..drive.reference.spec import make_reference
from ..drive.stability import check_stability
from ..drive.telemetry import simulation_recording
from ..errors import InputError
from ..recording.signals import Recording


def simulate(
    drive: DriveParameters | str | os.PathLike[str],
    reference: str | Recording,
    duration_s: float | None = None,
    *,
    progress: Callable[[float], None] | None = None,
) -> Recording:
    """What the drive does when it is asked to follow a reference.

    Args:
        drive: of a full cylinder: its parameters, a drive file, or a profile's name.
        reference: SPEC as `ecyl simulate --reference` takes it (`sine:amplitude=2e-5,frequency=1`,
            `chirp:...`, `multisine:...`, `moves:...`, the path of a recording), or a recording
            whose reference is played.
        duration_s: length of the run; of a recorded reference its own by default.
        progress: called now and then with the share done, 0 to 1.

    Returns:
        The same samples that `ecyl simulate` records.

    Raises:
        InputError: a reference that the drive's stroke or speed forbids, or a loop that is not
            stable at the drive's rate.
    """
    if isinstance(drive, DriveParameters):
        own, name = drive, "drive"
    else:
        own, name = load_drive(drive), str(drive)
    check_stability(own, name)
    if duration_s is not None and not (math.isfinite(duration_s) and duration_s > 0.0):
        raise InputError(f"duration_s = {duration_s:g}, expected more than 0 s")
    source: Reference
    if isinstance(reference, Recording):
        source = Recorded.from_recording(reference, "the reference's recording")
    else:
        source = make_reference(reference, own, duration_s or 60.0)
    if isinstance(source, SetpointFollower):
        raise InputError("reference setpoint needs the node graph; expected ecyl run")
    if duration_s is None:
        if not isinstance(source, Recorded):
            raise InputError("duration_s is missing; expected seconds to run")
        duration_s = source.duration_s + 1.0 / own.sample_rate
    rate = own.sample_rate
    done = run(own, lambda index: source.sample(index / rate), duration_s, progress=progress)
    return simulation_recording(done, own)
