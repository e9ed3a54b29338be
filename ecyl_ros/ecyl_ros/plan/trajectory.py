"""A motion as `trajectory_msgs/JointTrajectory`, for `ecyl/trajectory` or ros2_control.

Its points are where the jerk of moves changes, and close together in swings. Quintic splines
between them, as the drive's reference node and a joint_trajectory_controller lay them, are then the
motion itself.
"""

from __future__ import annotations

from typing import Any

import yaml

from ..drive.reference.planned import Planned

_NANO = 1_000_000_000


def trajectory(motion: Planned, joint: str) -> dict[str, Any]:
    """The message's fields as plain data: positions m, velocities m/s, accelerations m/s^2."""
    points = []
    for one in motion.points():
        assert one.velocity is not None and one.acceleration is not None  # a motion has both
        second, nanosecond = divmod(round(one.time_s * _NANO), _NANO)
        points.append(
            {
                "positions": [round(one.position, 15)],
                "velocities": [round(one.velocity, 12)],
                "accelerations": [round(one.acceleration, 9)],
                "time_from_start": {"sec": second, "nanosec": nanosecond},
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
