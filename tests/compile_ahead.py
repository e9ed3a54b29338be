"""Compile, ahead of the tests, the kernels that take longest.

Where two tests need one at once, both would compile it: `python -m tests.compile_ahead`.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from ecyl_ros.drive.drive_file import load_drive
from ecyl_ros.drive.engine import simulate
from ecyl_ros.drive.parameters import DriveParameters
from ecyl_ros.drive.warm_up import warm_up
from ecyl_ros.gap.diagnose import diagnose
from ecyl_ros.gap.replay.replay import Replay
from ecyl_ros.gap.study.case import Case
from ecyl_ros.gap.study.cylinder.cases import record_case
from ecyl_ros.gap.study.drives import Choice, RigidDrives, draw_cases


def _loops(drive: DriveParameters) -> list[DriveParameters]:
    """The drive with what makes another loop for the compiler: memory, delay, both."""
    remembers = dataclasses.replace(
        drive, controller=dataclasses.replace(drive.controller, setpoint_filter=1e-3)
    )
    late = {"measurement_delay": {"delay_s": 1e-4}}
    return [remembers, *(dataclasses.replace(one, effects=late) for one in (drive, remembers))]


def main() -> None:
    """Every loop of the engine, a replay under torque, a healthy machine of either study."""
    bench = load_drive("bench")
    warm_up(bench)
    for drive in _loops(bench):
        simulate(drive, lambda index: (0.0, 0.0), 2.0 / drive.controller.rate)
    recording = record_case(Case(0, 1, "none", {}), bench).slice(0.0, 2.0)
    replay = Replay(recording, bench, "ahead")
    replay.full({}, np.zeros((2, len(replay.time_s))))
    diagnose(recording, bench)
    rigid = RigidDrives()
    (case,) = draw_cases(rigid, 1, 1, Choice(kinds=("none",)))
    given = rigid.given(case)
    diagnose(given.recording, given.drive)


if __name__ == "__main__":
    main()
