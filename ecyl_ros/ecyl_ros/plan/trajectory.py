"""A motion as `trajectory_msgs/JointTrajectory`, for `ecyl/trajectory` or ros2_control.

Its points are where the motion's jerk changes. Quintic splines between them, as the drive's
reference node and a joint_trajectory_controller lay them, are then the motion itself.
"""

from __future__ import annotations

from typing import Any

import yaml

from ..drive.reference.planned import Planned

_NANO = 1_000_000_000


def trajectory(motion: Planned, joint: str) -> dict[str, Any]:
    """The message's fields as plain data: positions m, velocities m/s, accelerations m/s^2."""
    times = motion.switches()
    times = [*(time for time in times if time < motion.duration_s), motion.duration_s]
    stamps = [round(time * _NANO) for time in times]
    seconds = [stamp / _NANO for stamp in stamps]
    points = []
    for stamp, time, faster in zip(
        stamps, seconds, motion.accelerations(seconds).tolist(), strict=True
    ):
        position, velocity = motion.sample(time)
        points.append(
            {
                "positions": [round(position, 15)],
                "velocities": [round(velocity, 12)],
                "accelerations": [round(faster, 9)],
                "time_from_start": {"sec": stamp // _NANO, "nanosec": stamp % _NANO},
            }
        )
    return {"joint_names": [joint], "points": points}


def as_yaml(motion: Planned, joint: str) -> str:
    """The message as `ros2 topic pub` takes it."""
    data = trajectory(motion, joint)
    head = yaml.safe_dump({"joint_names": data["joint_names"]}, default_flow_style=False)
    rows = "".join(
        "- " + yaml.safe_dump(one, sort_keys=False, default_flow_style=True, width=400)
        for one in data["points"]
    )
    return f"{head}points:\n{rows}"
