"""A trajectory on the topic, to a drive in a namespace of its own."""

from __future__ import annotations

import math
import subprocess
import sys

from builtin_interfaces.msg import Duration
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from ecyl_ros.drive.drive_file import resolve_drive


def test_a_trajectory_is_followed_and_a_bad_one_refused(listener) -> None:
    """In a namespace: the rod goes where it says; beyond the stroke it is counted, not followed."""
    publisher = listener.create_publisher(JointTrajectory, "/left/ecyl/trajectory", 10)
    rod = [math.nan]
    listener.create_subscription(
        JointState,
        "/left/ecyl/joint_states",
        lambda message: rod.__setitem__(0, message.position[1]),
        1000,
    )
    arguments = ["--ros-args", "--params-file", str(resolve_drive("servo_1khz"))]
    nodes = [
        subprocess.Popen(
            [sys.executable, "-m", "ecyl_ros.nodes.entry", name, *arguments, "-r", "__ns:=/left"]
        )
        for name in ("plant", "controller", "reference")
    ]

    def say(*points: tuple[float, float]) -> None:
        publisher.publish(
            JointTrajectory(
                joint_names=["rod"],
                points=[
                    JointTrajectoryPoint(
                        positions=[position],
                        time_from_start=Duration(sec=int(time_s), nanosec=int(time_s % 1 * 1e9)),
                    )
                    for time_s, position in points
                ],
            )
        )

    try:
        assert listener.until(lambda: rod[0] == rod[0] and publisher.get_subscription_count() > 0)
        say((1.5, 0.02), (2.5, 0.01))
        assert listener.until(lambda: rod[0] > 0.019)
        assert listener.until(lambda: abs(rod[0] - 0.01) < 2e-4)
        say((1.0, 9.0))
        status = "left/ecyl/reference setpoints"
        assert listener.until(
            lambda: listener.statuses.get(status, {}).get("trajectories_refused") == "1"
        ), listener.statuses
        assert listener.statuses[status]["trajectories_accepted"] == "1"
        assert "the stroke" in listener.statuses[status]["last_refusal"]
        assert abs(rod[0] - 0.01) < 5e-4
    finally:
        for node in nodes:
            node.terminate()
        for node in nodes:
            node.wait(20)
