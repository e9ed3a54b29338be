"""How a node's process ends."""

from __future__ import annotations

import pytest

from ecyl_ros.drive.drive_file import resolve_drive
from ecyl_ros.errors import InputError
from ecyl_ros.nodes.drive_node import DriveNode
from ecyl_ros.nodes.run_node import run_node

FULL = "a.mcap: cannot be written: No space left on device"


class OnFullDisk(DriveNode):
    """Writes in vain, once while it spins and once more when it closes."""

    def __init__(self) -> None:
        drive = ["--ros-args", "--params-file", str(resolve_drive("bench"))]
        super().__init__("recorder", {}, cli_args=drive)
        self.create_timer(0.01, self.close)

    def close(self) -> None:
        """Write."""
        raise InputError(FULL)


def test_a_disk_that_is_full_is_said_once(capfd: pytest.CaptureFixture[str]) -> None:
    """One line, no traceback, exit code 2, though closing the file fails as writing it did."""
    assert run_node(OnFullDisk, args=[]) == 2
    assert capfd.readouterr().err.strip().splitlines() == [f"ecyl: {FULL}"]
