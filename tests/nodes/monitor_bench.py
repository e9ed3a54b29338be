"""Known drives, and a bench that sends them to a gap monitor and keeps what it says."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import Vector3Stamped
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import HistoryPolicy, QoSProfile
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

from ecyl_ros.drive.drive_file import resolve_drive
from ecyl_ros.drive.engine import simulate
from ecyl_ros.drive.parameters import DriveParameters
from ecyl_ros.drive.reference.spec import make_reference
from ecyl_ros.drive.telemetry import simulation_recording
from ecyl_ros.nodes.gap_monitor import GapMonitor
from ecyl_ros.recording import cdr
from ecyl_ros.recording.signals import Recording
from ecyl_ros.recording.topics import JOINT_STATE, TOPICS

SWING = "sine:amplitude=5e-3,frequency=1"
STATUS = "ecyl/gap_monitor gap"
CHUNK = 50  # samples at a time


def recorded(
    drive: DriveParameters, seconds: float, effects: dict | None = None, *, reference: str = SWING
) -> Recording:
    """A run of the drive with these effects and noise that no twin draws."""
    sensors = dataclasses.replace(drive.sensors, noise_seed=4711)
    worn = dataclasses.replace(drive, effects=effects or {}, sensors=sensors)
    follow = make_reference(reference, worn, seconds)
    run = simulate(worn, lambda index: follow.sample(index / worn.sample_rate), seconds)
    return simulation_recording(run, worn)


class Bench(Node):
    """Sends recordings to a monitor in the same process and keeps what it says."""

    def __init__(self, drive: str = "bench", **own: object) -> None:
        super().__init__("bench")
        everything = QoSProfile(history=HistoryPolicy.KEEP_ALL, depth=0)
        kinds = {JOINT_STATE: JointState}
        self.outputs = {
            topic.key: self.create_publisher(
                kinds.get(topic.type, Vector3Stamped), topic.name, everything
            )
            for topic in TOPICS
        }
        self.reports: list[DiagnosticStatus] = []
        self.residuals: list[tuple[int, float, float]] = []  # stamp ns, rotor rad, rod m
        self.levels: list[float] = []
        self.create_subscription(DiagnosticArray, "/diagnostics", self._on_diagnostics, 100)
        self.create_subscription(
            JointState, "/ecyl/gap/joint_states", self._on_residual, everything
        )
        self.create_subscription(
            Float64, "/ecyl/gap/over_noise/rotor_position", self._on_level, everything
        )
        self.monitor = GapMonitor(
            cli_args=["--ros-args", "--params-file", str(resolve_drive(drive))],
            parameter_overrides=[Parameter(key, value=value) for key, value in own.items()],
        )
        self.executor_ = SingleThreadedExecutor()
        for one in (self, self.monitor):
            self.executor_.add_node(one)

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        self.reports += [status for status in message.status if status.name == STATUS]

    def _on_residual(self, message: JointState) -> None:
        stamp = message.header.stamp
        self.residuals.append(
            (stamp.sec * 10**9 + stamp.nanosec, message.position[0], message.position[1])
        )

    def _on_level(self, message: Float64) -> None:
        self.levels.append(message.data)

    def until(self, condition: Callable[[], bool], seconds: float = 60.0) -> bool:
        """Spin until a condition holds."""
        deadline = time.monotonic() + seconds
        while time.monotonic() < deadline:
            self.executor_.spin_once(timeout_sec=0.02)
            if condition():
                return True
        return False

    def send(self, recording: Recording, *, without: tuple[str, ...] = ()) -> None:
        """Publish a recording as fast as the monitor takes it."""
        for start in range(0, len(recording), CHUNK):
            part = slice(start, start + CHUNK)
            count = 0
            for topic in TOPICS:
                if topic.key in without:
                    continue
                columns = {
                    path: recording.signal(signal)[part]
                    for path, signal in topic.signals.items()
                    if path.split(".")[0] in (*topic.joints, "vector")
                }
                if topic.key in ("current", "voltage"):
                    columns["vector.z"] = np.zeros(len(recording.stamp_ns[part]))
                for message in cdr.encode(
                    topic.type, topic.frame_id, topic.joints, recording.stamp_ns[part], columns
                ):
                    self.outputs[topic.key].publish(message)
                    count += 1
            wanted = self.monitor.handled + count
            assert self.until(lambda wanted=wanted: self.monitor.handled >= wanted)

    def report(self, fresh: Callable[[DiagnosticStatus], bool] | None = None) -> DiagnosticStatus:
        """The next status that is `fresh`, or simply the next one, while the drive goes on."""
        seen = len(self.reports)
        wanted = fresh or (lambda _: True)
        assert self.until(lambda: any(wanted(one) for one in self.reports[seen:])), [
            one.message for one in self.reports
        ]
        return next(one for one in self.reports[seen:] if wanted(one))

    def judged(self) -> DiagnosticStatus:
        """The next status about a gap or none."""
        return self.report(lambda one: "gap" in one.message)

    def close(self) -> None:
        """End both nodes."""
        self.executor_.shutdown()
        self.monitor.destroy_node()
        self.destroy_node()


def values_of(status: DiagnosticStatus) -> dict[str, str]:
    """Values of a status by key."""
    return {item.key: item.value for item in status.values}
