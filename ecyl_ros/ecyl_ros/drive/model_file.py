"""Any drive file: of a full cylinder, or with `drive.kind` of a rigid drive or a follower."""

from __future__ import annotations

import os

from .drive_file import drive_from_flat, read_parameter_file, resolve_drive
from .parameters import DriveParameters
from .rigid.machine import Machine
from .rigid.machine_file import machine_from_flat


def load_model(name: str | os.PathLike[str]) -> DriveParameters | Machine:
    """Read and check a drive file, or a profile shipped with the package.

    Raises:
        InputError: unreadable, unknown key or a value that is not possible.
    """
    path = resolve_drive(name)
    flat = read_parameter_file(path)
    if any(key.startswith("drive.") for key in flat):
        return machine_from_flat(flat, str(path))
    return drive_from_flat(flat, str(path))
