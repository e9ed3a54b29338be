"""Flags of a diagnosis that mean nothing for some kind of drive."""

from __future__ import annotations

import argparse
from pathlib import Path

from ..errors import InputError


def check_kind(options: argparse.Namespace, drive_file: Path) -> None:
    """Refuse flags that mean nothing for the kind of drive that the file describes."""
    from ..drive.model_file import load_model
    from ..drive.parameters import DriveParameters

    drive = load_model(drive_file)
    if isinstance(drive, DriveParameters):
        if options.mode is not None:
            raise InputError(
                f"--mode {options.mode:g}: {drive_file} describes a full cylinder; expected a "
                "drive file with drive.kind, see docs/drive-file.md"
            )
    elif options.write_drive is not None and drive.kind == "follower":
        raise InputError(
            f"--write-drive {options.write_drive}: not for a drive of kind follower; its "
            "measured values are in the JSON and the report"
        )
