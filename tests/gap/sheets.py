"""Drives whose constants are all known."""

from __future__ import annotations

import dataclasses
from pathlib import Path

from ecyl_ros.drive.drive_file import load_drive
from ecyl_ros.drive.parameters import DriveParameters


def exact(name: str | Path) -> DriveParameters:
    """A profile or drive file, its constants exact."""
    return dataclasses.replace(load_drive(name), tolerances={"all": "exact"})
