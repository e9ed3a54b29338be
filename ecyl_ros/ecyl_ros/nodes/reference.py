"""The reference node: publishes what the rod shall do, a little ahead of the plant's time.

Samples come at the telemetry rate and carry the instant they are meant for; the controller
interpolates. The plant's telemetry paces the node, so that it runs as fast as the plant does.
"""

from __future__ import annotations

import math
from collections import deque
from typing import Any

from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticStatus
from rclpy.clock import Clock, ClockType
from rclpy.publisher import Publisher
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64, Header
from trajectory_msgs.msg import JointTrajectory

from ..drive.parameters import DriveParameters
from ..drive.reference.setpoint import SetpointFollower
from ..drive.reference.spec import make_reference
from ..drive.reference.trajectory import Point
from ..drive.telemetry import NANOSECONDS, tick_stamp_ns
from ..errors import InputError
from . import wire
from .drive_node import DriveNode
from .ready_bytes import Outgoing
from .run_node import run_node
from .scheduling import run_as_others, run_first

# Samples ahead of the plant. What a live setpoint changes is said again from the next sample on, so
# that it acts at once; this many samples bridge a moment in which the machine is busy.
SETPOINT_LOOKAHEAD = 16
GENERATED_LOOKAHEAD = 128
START_S = 0.05  # real time: from a trajectory's coming, with the drive at rest, to its beginning
CHECKED_S = 60.0  # how much of an endless reference is checked against stroke and speed


class ReferenceGenerator(DriveNode):
    """Publishes the reference of a SPEC, or follows `ecyl/setpoint` and `ecyl/trajectory`."""

    live = ("limits.",)

    def __init__(self, **options) -> None:
        super().__init__(
            "reference",
            {
                "reference": ("setpoint", "what to follow: sine:..., setpoint, or a recording"),
                "lookahead": (0, "samples published ahead of the plant; 0: chosen by kind"),
                "duration": (0.0, "s of the run, to check the reference over; 0: endless"),
            },
            **options,
        )
        self._spec: str = self.option("reference")
        self._reference = self._make()
        self._follower = isinstance(self._reference, SetpointFollower)
        lookahead = self.option("lookahead")
        if lookahead < 0 or lookahead > 1000:
            raise InputError(f"node reference: lookahead = {lookahead}, expected 0 to 1000 samples")
        self._lookahead = lookahead or (
            SETPOINT_LOOKAHEAD if self._follower else GENERATED_LOOKAHEAD
        )
        if not self._follower:  # far ahead of the plant: no hurry
            self.batch_s = 1e-3
        self._every = self.drive.telemetry_every
        self._rate = self.drive.controller.rate
        self._epoch_ns: int | None = None
        self._next = 0
        self._plant_sample = 0
        self._waiting_ns: int | None = None  # stamp the plant last said it waits at
        self._rod_position = 0.0

        self._leads = False  # whether a sample of ours was said when its time had come
        self.skipped = 0  # real time: samples over before they could be said
        # Said to the controller, not yet as telemetry: index, stamp, message, and where a follower
        # stood then.
        self._ahead: deque[tuple[int, int, bytes, Any]] = deque()
        self._before: Any = None  # where the follower stood at the last sample said as telemetry
        self._bytes = Outgoing(
            JointState(
                header=Header(frame_id=wire.ROD_FRAME),
                name=[wire.ROD],
                position=[0.0],
                velocity=[0.0],
            ),
            "rod.position",
            "rod.velocity",
        )
        self._realtime: bool = self.option("realtime")

        self._telemetry = self.create_publisher(
            JointState, wire.REFERENCE, wire.telemetry(self._realtime)
        )
        self._publisher: Publisher | None = None  # there when we are ready
        self.when_recorded(wire.REFERENCE, self._be_ready)
        self.create_subscription(Time, wire.EPOCH, self._on_epoch, wire.latched())
        self.create_subscription(Time, wire.WAITING, self._on_waiting, 10)
        self.create_subscription(
            JointState,
            wire.JOINT_STATES,
            self._on_joint_states,
            wire.plant_time(self._realtime),
        )
        if self._follower:
            self.create_subscription(Float64, wire.SETPOINT, self._on_setpoint, 64)
            self.create_subscription(JointTrajectory, wire.TRAJECTORY, self._on_trajectory, 4)
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(1.0, self._publish_diagnostics, clock=steady)
        self._last_reason = ""

    def _be_ready(self) -> None:
        # Latched, so that a controller that starts again gets the samples it is to go on from.
        self._publisher = self.create_publisher(
            JointState, wire.CONTROL_REFERENCE, wire.latched(2 * self._lookahead + 64)
        )
        self._publish_ahead()

    def _make(self):
        duration = self.option("duration") or CHECKED_S
        return make_reference(self._spec, self.drive, duration)

    def _on_epoch(self, message: Time) -> None:
        """A run begins, or goes on if this node joins it late."""
        if self._epoch_ns is not None:
            self.get_logger().info("the plant restarted: the reference starts over")
            self._reference = self._make()
        self._epoch_ns = wire.to_ns(message)
        if self._realtime and self._follower:
            run_first()  # a setpoint's way to the controller; where refused, the plant says so
        self._plant_sample = 0
        self._say_from(0)
        self._publish_ahead()

    def _on_joint_states(self, message: JointState) -> None:
        if len(message.position) > 1 and math.isfinite(message.position[1]):
            self._rod_position = message.position[1]
        self._waiting_ns = None
        self._advance(wire.to_ns(message.header.stamp))

    def _on_waiting(self, message: Time) -> None:
        """The plant stands still, perhaps for want of what the reference said before it ended.

        Or because the reference is ahead of it: a plant that was killed may be heard once more when
        the one after it has begun. Said twice of one tick, that is so.
        """
        stamp_ns = wire.to_ns(message)
        again, self._waiting_ns = stamp_ns == self._waiting_ns, stamp_ns
        if again and self._epoch_ns is not None:
            sample = self._sample_at(stamp_ns)
            if sample < self._plant_sample:
                self.get_logger().info(f"the plant is at sample {sample}: back to it")
                self._plant_sample = sample
                self._begin_at(sample)
        self._advance(stamp_ns)

    def _sample_at(self, stamp_ns: int) -> int:
        """The newest sample at a stamp of the run."""
        ticks = round((stamp_ns - (self._epoch_ns or 0)) * self._rate / NANOSECONDS)
        return ticks // self._every

    def _begin_at(self, sample: int) -> None:
        """Say what is to come from this sample on, a follower from where the rod is."""
        self._say_from(sample)
        if isinstance(self._reference, SetpointFollower):
            self._reference = SetpointFollower(
                self.drive.limits, 1.0 / self.drive.sample_rate, self._rod_position
            )

    def _advance(self, stamp_ns: int) -> None:
        """Publish what is due when the plant has reached `stamp_ns`."""
        self.heard_partner()
        if self._epoch_ns is None:
            return
        sample = self._sample_at(stamp_ns)
        if sample < self._plant_sample:
            return  # a message of the run before
        self._plant_sample = sample
        if self._next < sample:
            self._go_on_at(sample)
        self._publish_ahead()
        self._publish_telemetry(stamp_ns)

    def _go_on_at(self, sample: int) -> None:
        """Leave out samples that are over: the run went on before we came, or while we waited."""
        self.skipped += sample - self._next
        if not self._leads:
            self.get_logger().info(f"joining the run at sample {sample}")
            self._begin_at(sample)
            return
        if isinstance(self._reference, SetpointFollower):
            for index in range(self._next, sample):  # what it follows goes on where it would be
                self._reference.sample(index / self.drive.sample_rate)
        self._say_from(sample)

    def _say_from(self, sample: int) -> None:
        """Have this sample said next, and nothing that was said before it or after."""
        self._next = sample
        self._ahead.clear()
        self._before = None

    def _publish_ahead(self) -> None:
        if self._publisher is None or self._epoch_ns is None:
            return
        while self._next <= self._plant_sample + self._lookahead:
            position, velocity = self._reference.sample(self._next / self.drive.sample_rate)
            stamp_ns = tick_stamp_ns(self._next * self._every, self._rate, self._epoch_ns)
            message = self._bytes.pack(stamp_ns, (position, velocity))
            self._publisher.publish(message)
            state = self._reference.state if self._follower else None
            self._ahead.append((self._next, stamp_ns, message, state))
            self._next += 1

    def _publish_telemetry(self, stamp_ns: int) -> None:
        """Say the samples whose time has come."""
        while self._ahead and self._ahead[0][1] <= stamp_ns:
            _, _, message, self._before = self._ahead.popleft()
            self._leads = True
            self._telemetry.publish(message)

    def _sample_now(self) -> int:
        """The newest sample whose time has come, as far as this node can know."""
        if not self._realtime or self._epoch_ns is None:
            return self._plant_sample
        elapsed_s = (self.get_clock().now().nanoseconds - self._epoch_ns) / NANOSECONDS
        return max(self._plant_sample, math.floor(elapsed_s * self.drive.sample_rate))

    def _stood(self, now: int) -> tuple[int, Any]:
        """The last sample until `now` that was said, and where the follower stood then."""
        kept = [entry for entry in self._ahead if entry[0] <= now]
        if kept:
            return kept[-1][0], kept[-1][3]
        if self._ahead:
            return self._ahead[0][0] - 1, self._before
        return self._next - 1, self._reference.state

    def _say_anew(self, now: int) -> None:
        """Take back what was said of the samples after `now`, and say it for what was accepted."""
        kept = [entry for entry in self._ahead if entry[0] <= now]
        if len(kept) == len(self._ahead):
            return  # nothing said of what is to come
        _, state = self._stood(now)
        if state is None:
            return  # not a sample has been: what was said begins with the rod at rest
        self._next = self._ahead[len(kept)][0]
        self._ahead = deque(kept)
        self._reference.go_back(state)
        self._publish_ahead()

    def _on_setpoint(self, message: Float64) -> None:
        now = self._sample_now()
        reason = self._reference.offer(message.data, now / self.drive.sample_rate)
        if reason is None:
            self._say_anew(now)
        else:
            self._warn(reason, self._reference.refused)

    def _on_trajectory(self, message: JointTrajectory) -> None:
        now = self._sample_now()
        try:
            points = _points(message)
        except ValueError as error:
            self._reference.trajectories_refused += 1
            self._warn(str(error), self._reference.trajectories_refused)
            return
        if not points:  # to come to rest brooks no delay
            last, state = self._stood(now)
            now_s = now / self.drive.sample_rate
            self._reference.offer_trajectory([], state or self._reference.state, now_s, now_s)
            self._say_anew(now)
            return
        # What has been said stays: to lay splines and check them takes a moment.
        last, state = max(self._next - 1, 0), self._reference.state
        if self._realtime and state[1:] == (0.0, 0.0):
            last = max(last, now + math.ceil(START_S * self.drive.sample_rate))
        begin_s = last_s = last / self.drive.sample_rate
        stamp_ns = wire.to_ns(message.header.stamp)
        if stamp_ns:
            begin_s = (stamp_ns - (self._epoch_ns or 0)) / NANOSECONDS
        reason = self._reference.offer_trajectory(points, state, last_s, begin_s)
        if reason is not None:
            self._warn(reason, self._reference.trajectories_refused)

    def _warn(self, reason: str, refused: int) -> None:
        """Say why something was refused, here and on diagnostics."""
        self._last_reason = reason
        self.get_logger().warning(
            f"refused ({refused} so far): {reason}", throttle_duration_sec=1.0
        )
        self._publish_diagnostics()

    def _publish_diagnostics(self) -> None:
        if not isinstance(self._reference, SetpointFollower):
            return
        follower = self._reference
        values = {
            "setpoints_accepted": str(follower.accepted),
            "setpoints_refused": str(follower.refused),
            "trajectories_accepted": str(follower.trajectories_accepted),
            "trajectories_refused": str(follower.trajectories_refused),
            "last_refusal": self._last_reason,
        }
        refused = follower.refused + follower.trajectories_refused
        level = DiagnosticStatus.WARN if refused else DiagnosticStatus.OK
        self.report(level, "reference setpoints", self._last_reason or "following", values)

    def waiting_for(self) -> str | None:
        """The plant, always: it sets the time."""
        return "a plant on " + self.resolve_topic_name(wire.JOINT_STATES)

    def close(self) -> None:
        """Say what a real-time run was short of."""
        if self._realtime:
            run_as_others()
        if self._realtime and self.skipped:
            self.last_words(f"{self.skipped} samples were over before they could be said")

    def on_drive_changed(self, drive: DriveParameters) -> None:
        """Changed limits hold for setpoints from now on."""
        if isinstance(self._reference, SetpointFollower):
            self._reference.change_limits(drive.limits)


def _points(message: JointTrajectory) -> list[Point]:
    """The rod's points, none to come to rest; ValueError says what was expected instead."""
    if not message.points and not message.joint_names:
        return []  # names none, either
    if list(message.joint_names) != [wire.ROD]:
        raise ValueError(
            f"trajectory of joints {list(message.joint_names)}, expected ['{wire.ROD}']"
        )
    found = []
    for number, one in enumerate(message.points, start=1):
        for name in ("positions", "velocities", "accelerations"):
            count = len(getattr(one, name))
            if count > 1 or (name == "positions" and count == 0):
                raise ValueError(f"trajectory point {number}: {count} {name}, expected 1")
        time = one.time_from_start
        found.append(
            Point(
                time.sec + 1e-9 * time.nanosec,
                one.positions[0],
                one.velocities[0] if one.velocities else None,
                one.accelerations[0] if one.accelerations else None,
            )
        )
    return found


def main(args: list[str] | None = None) -> int:
    """Entry point of `reference`."""
    return run_node(ReferenceGenerator, args)
