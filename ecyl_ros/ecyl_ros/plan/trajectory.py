"""A motion as `trajectory_msgs/JointTrajectory`, for a ros2_control joint_trajectory_controller."""

from __future__ import annotations

from typing import Any

import numpy as np
import yaml

from ..drive.reference.planned import Planned

_RATE_HZ = 100.0  # of the points: the controller's quintic splines between them are exact enough


def trajectory(motion: Planned, joint: str) -> dict[str, Any]:
    """The message's fields as plain data: positions m, velocities m/s, accelerations m/s^2."""
    count = max(1, round(motion.duration_s * _RATE_HZ))
    times = np.arange(count + 1) / _RATE_HZ
    times[-1] = motion.duration_s
    faster = motion.accelerations(times.tolist())
    points = []
    for time, acceleration in zip(times.tolist(), faster.tolist(), strict=True):
        position, velocity = motion.sample(time)
        nanoseconds = round(time * 1e9)
        points.append(
            {
                "positions": [round(position, 9)],
                "velocities": [round(velocity, 9)],
                "accelerations": [round(acceleration, 9)],
                "time_from_start": {
                    "sec": nanoseconds // 1_000_000_000,
                    "nanosec": nanoseconds % 1_000_000_000,
                },
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
