"""Drives by name, and drives with other values."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any

from ..drive.drive_file import drive_from_flat, drive_to_flat
from ..drive.model_file import load_model
from ..drive.parameters import DriveParameters
from ..drive.rigid.machine import Machine


def load_drive(name: str | os.PathLike[str]) -> DriveParameters | Machine:
    """The drive that a drive file describes.

    Args:
        name: path of a drive file, or a profile: `paper`, `si`, `bench`, `servo_1khz`, `worn_1khz`.

    Returns:
        `DriveParameters` of a full cylinder, a `Machine` where the file has `drive.kind`.

    Raises:
        InputError: unreadable, an unknown key, or a value that is not possible.
    """
    return load_model(name)


def changed(drive: DriveParameters, values: Mapping[str, Any]) -> DriveParameters:
    """The drive with other values, checked as a drive file is; the given one stays as it is.

    Args:
        drive: of a full cylinder.
        values: dotted key of the drive file -> value in SI units, such as
            `{"transmission.backlash": 2e-3, "effects.cogging_torque.amplitude_nm": 0.05}`.

    Raises:
        InputError: an unknown key, or a value that is not possible.
    """
    return drive_from_flat({**drive_to_flat(drive), **values}, "changed")
