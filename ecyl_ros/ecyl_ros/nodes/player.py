"""Plays one motion on a drive, watches every sample of it, and records it.

For drives that follow a trajectory or setpoints, of this project or others. Whatever lies beyond
the bounds, and whoever falls silent, ends the motion: the drive is asked to come to rest, and what
was recorded is kept.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from builtin_interfaces.msg import Duration
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.task import Future
from std_msgs.msg import Float64
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from ..drive.parameters import LimitParameters
from ..drive.reference.trajectory import Point, Trajectory, made
from ..errors import InputError
from ..investigate.bounds import Bounds, Sample
from ..investigate.played import Played, Seen
from . import wire
from .hearing import NEEDED, Hearing, telemetry_name

TOLD_MISSED = "missed_ticks"  # key in the status of a drive that keeps the wall clock
TOPIC_OF = {"trajectory": wire.TRAJECTORY, "setpoint": wire.SETPOINT}  # in the order of preference

TICK_S = 0.05  # wall: how often silence is looked for
GATHER_S = 1.0  # wall, once the drive is heard: for topics that are discovered later
CONNECT_S = 20.0  # wall, for the drive to be heard and to hear
STATUS_S = 1.5  # wall, for a status of what it has refused so far; they come once a second
REST_S = 0.3  # of the drive's time, at rest before and after
LEAD_S, TAIL_S = 0.1, 0.2  # recorded before the motion begins and after it has ended
FOLLOW_S = 2.0  # wall and drive's time, for the reference to begin to move
SETTLE_S = 5.0  # of the drive's time, for a drive on setpoints to get to the end
STOP_S = 5.0  # wall and drive's time, for the drive to come to rest
DEAF_STOP_S = 1.0  # wall, the same if it is silent
HOLD_AFTER_S = 0.3  # wall: a drive that has not slowed down by then is given a place to stop at
SETPOINT_EVERY_S = 0.04
STILL_M, STILL_M_S = 1e-9, 1e-6
_AT_START_M = 1e-6
_APPROACH = 0.5  # of speed and acceleration, on the way to where motions start
_LATE_SAMPLES = 3  # that a reference may be behind the motion that was asked for


@dataclass(frozen=True)
class Task:
    """What is to be played.

    Attributes:
        bounds: that every sample keeps. points: the motion, from 0 m and back to rest; none: only
            look at the drive. out: recording to write.
        follow: `trajectory`, `setpoint`, or `auto`: the first of these that the drive follows.
        joint: of the rod, in trajectories. names: topic names by key, where they are others.
        silence_s: wall time without telemetry that ends the motion.
    """

    bounds: Bounds | None = None
    points: tuple[Point, ...] = ()
    out: Path | None = None
    follow: str = "auto"
    joint: str = wire.ROD
    names: Mapping[str, str] = field(default_factory=dict)
    silence_s: float = 1.0

    @property
    def limits(self) -> LimitParameters:
        """That the reference keeps."""
        assert self.bounds is not None  # of a task that moves
        return self.bounds.limits


class Player:
    """One task, from first contact to rest; `done` gets a `Seen`, a `Played` or an `InputError`."""

    def __init__(self, node: Node, task: Task, alive: Callable[[], str | None]) -> None:
        """alive: why the drive's own processes have ended, if they are known; None: they run."""
        self.done: Future = Future()
        self._node, self._task, self._alive = node, task, alive
        self._began = time.monotonic()
        self._phase: Callable[[Sample], None] = self._look
        self._then: Callable[[Sample], None] = self._rest  # after what is being played
        self._last: Sample | None = None
        self._period = 0.0  # between the last two samples, s
        self._since: float | None = None  # drive's time at which what a phase waits for began
        self._home = 0.0  # where the reference rests
        self._follows = ""
        self._motion: Trajectory | None = None
        self._sent_wall = self._sent_at = 0.0  # when it was sent: wall, drive's time; 0: never
        self._begun: float | None = None  # drive's time at which the reference began to move
        self._streamed = self._streamed_wall = 0.0  # when the last setpoint was sent, both times
        self._refused: int | None = None  # by the drive so far; None: it has not said
        self._missed: list[int] = []  # control ticks, by the drive's statuses so far
        self._samples, self._error_m, self._current_a = 0, 0.0, 0.0
        self._recording: Path | None = None  # once it is closed
        self._statuses, self._waits_from = 0, 0.0
        self._ended = ""
        self._stopping = self._stopping_at = self._speed_then = 0.0
        self._given_place = False

        names = task.names
        self._publishers = {
            "trajectory": node.create_publisher(
                JointTrajectory, names.get("trajectory", wire.TRAJECTORY), 4
            ),
            "setpoint": node.create_publisher(Float64, names.get("setpoint", wire.SETPOINT), 64),
        }
        self._hearing = Hearing(node, names, self._on_sample, self._fail)
        node.create_subscription(DiagnosticArray, wire.DIAGNOSTICS, self._on_diagnostics, 10)
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        node.create_timer(TICK_S, self._tick, clock=steady)

    # What comes in.

    def _on_sample(self, sample: Sample) -> None:
        if self.done.done():
            return
        if self._last is not None:
            self._period = sample.time_s - self._last.time_s
        self._last = sample
        if self._hearing.writer is not None:
            self._samples += 1
            self._error_m = max(self._error_m, abs(sample.reference - sample.rod))
            self._current_a = max(self._current_a, abs(sample.current), key=_or_nothing)
        bounds = self._task.bounds
        if bounds is not None and not self._ended:
            beyond = bounds.objection(sample)
            if beyond is not None:
                self.end(beyond)
        self._phase(sample)

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        prefix = f"{self._node.get_namespace()}/ecyl/".lstrip("/")
        for status in message.status:
            if not status.name.startswith(prefix):
                continue
            values = {one.key: one.value for one in status.values}
            if TOLD_MISSED in values:
                self._missed.append(int(values[TOLD_MISSED]))
            if "setpoints_refused" in values:
                refused = int(values["setpoints_refused"])
                refused += int(values.get("trajectories_refused", 0))
                if self._refused is not None and refused > self._refused:
                    self.end(f"the drive refused: {values.get('last_refusal', '')}")
                self._refused = refused
            elif status.level == DiagnosticStatus.ERROR and self._sent_wall:
                self.end(f"{status.name.removeprefix(prefix)}: {status.message}")

    # Wall time.

    def _tick(self) -> None:
        if self.done.done():
            return
        gone = self._alive()
        if not self._hearing.begun:
            self._connect(gone)
            return
        silent = self._hearing.silent(self._task.silence_s, self._began)
        if gone is not None:
            self.end(gone)
        elif silent is not None:
            self.end(f"nothing heard on {silent} for {self._task.silence_s:g} s")
        elif self._sent_wall and self._begun is None and not self._ended:
            assert self._last is not None
            late = time.monotonic() - self._sent_wall > FOLLOW_S
            if late and self._last.time_s - self._sent_at > FOLLOW_S:
                self._fail(
                    f"the drive does not follow {self._name(self._follows)}: its reference stayed "
                    f"at {self._home:g} m for {FOLLOW_S:g} s"
                )
        if self._ended:
            self._stop(deaf=gone is not None or silent is not None)

    def _connect(self, gone: str | None) -> None:
        if gone is not None:
            self._fail(gone)
            return
        follow = self._task.follow
        wanted = tuple(TOPIC_OF) if follow == "auto" else (follow,)
        hears = [key for key in wanted if self._publishers[key].get_subscription_count() > 0]
        waiting = self._hearing.waits_for()
        lacking = [key for key in NEEDED if key not in self._hearing.heard]
        waited = time.monotonic() - self._began
        first = max(self._hearing.heard_first.get(key, math.inf) for key in NEEDED)
        gathered = time.monotonic() - first > GATHER_S
        if hears and not lacking and ((gathered and waiting is None) or waited > CONNECT_S):
            self._follows = hears[0]
            self._hearing.begin()
            self._began = time.monotonic()
        elif waited > CONNECT_S:
            said = [f"telemetry on {self._name(key)}" for key in lacking]
            if not hears:
                topics = " or ".join(self._name(key) for key in wanted)
                said.append(f"a drive that follows {topics}")
            self._fail(f"no drive: waited {CONNECT_S:g} s for {' and '.join(said)}")

    def _name(self, key: str) -> str:
        names = self._task.names
        if key in TOPIC_OF:
            return self._node.resolve_topic_name(names.get(key, TOPIC_OF[key]))
        return self._node.resolve_topic_name(telemetry_name(key, names))

    # The phases; each takes the next sample.

    def _look(self, sample: Sample) -> None:
        """Before anything moves: is the drive at rest?"""
        if self._since is None:
            self._since, self._home = sample.time_s, sample.reference
        if abs(sample.reference - self._home) > STILL_M:
            self._fail(
                f"the drive is moving already: {self._name('reference')} went from "
                f"{self._home:.6g} m to {sample.reference:.6g} m; expected a drive at rest that "
                "nothing else commands"
            )
            return
        rested = sample.time_s - self._since > REST_S
        known = self._refused is not None or time.monotonic() - self._began > STATUS_S
        if not (rested and known):
            return
        if not self._task.points:
            self.done.set_result(Seen(self._follows, self._hearing.keys, self._home))
            return
        self._refused = self._refused or 0
        there = abs(self._home)
        if there <= _AT_START_M:
            self._rest(sample)
            return
        limits = self._task.limits
        time_s = max(
            1.875 * there / (_APPROACH * limits.speed),  # peaks of a quintic from rest to rest
            (5.7735 * there / (_APPROACH * limits.acceleration)) ** 0.5,
            0.2,
        )
        self._send(sample, (Point(time_s, 0.0, 0.0, 0.0),), self._rest)

    def _rest(self, sample: Sample) -> None:
        """At the start, before the motion: at rest for a moment, the end of it recorded."""
        if self._phase != self._rest:
            self._phase, self._since, self._home = self._rest, sample.time_s, sample.reference
        assert self._since is not None and self._task.out is not None
        waited = sample.time_s - self._since
        if waited > REST_S and self._hearing.writer is None:
            self._hearing.record(self._task.out)
        if waited > REST_S + LEAD_S:
            self._send(sample, self._task.points, self._finish)

    def _send(
        self, sample: Sample, points: tuple[Point, ...], then: Callable[[Sample], None]
    ) -> None:
        """Have the drive play `points` from where its reference rests."""
        self._motion = made(points, (self._home, 0.0, 0.0), 0.0, 0.0)
        self._sent_wall, self._sent_at, self._begun = time.monotonic(), sample.time_s, None
        self._phase, self._then = self._playing, then
        if self._follows == "trajectory":
            self._publishers["trajectory"].publish(_message(self._task.joint, points))
        else:
            self._streamed, self._streamed_wall = sample.time_s - SETPOINT_EVERY_S, 0.0
            self._stream(sample)

    def _stream(self, sample: Sample) -> None:
        """The setpoint whose time has come.

        By the drive's time and by the wall: samples that come in a burst, as in lockstep, would
        have setpoints sent at once that the drive takes for a leap.
        """
        assert self._motion is not None
        now = time.monotonic()
        apart = min(sample.time_s - self._streamed, now - self._streamed_wall)
        if apart >= SETPOINT_EVERY_S:
            self._streamed, self._streamed_wall = sample.time_s, now
            place = self._motion.at(sample.time_s - self._sent_at)[0]
            self._publishers["setpoint"].publish(Float64(data=place))

    def _playing(self, sample: Sample) -> None:
        if self._follows == "setpoint":
            self._stream(sample)
        if self._begun is None:
            if abs(sample.reference - self._home) <= STILL_M:
                return
            self._begun = sample.time_s - self._into(sample)
        if self._follows == "setpoint":
            self._pursued(sample)
        else:
            self._followed(sample)

    def _into(self, sample: Sample) -> float:
        """How long ago the motion began, s, of a reference that has just been seen to move."""
        assert self._motion is not None
        times = np.arange(0.0, sample.time_s - self._sent_at + self._period, 0.25 * self._period)
        places = self._motion.states(times)[0]
        return float(times[np.argmin(np.abs(places - sample.reference))])

    def _followed(self, sample: Sample) -> None:
        """A trajectory is played as it is: whatever else the reference does is not ours."""
        assert self._motion is not None and self._begun is not None
        into = sample.time_s - self._begun
        off = abs(sample.reference - self._motion.at(into)[0])
        if off > _LATE_SAMPLES * self._period * self._task.limits.speed + _AT_START_M:
            self.end(
                f"reference {1e3 * off:.3g} mm off the motion that was asked for, {into:.2f} s "
                "into it: something else commands the drive"
            )
        elif into > self._motion.end_s + _LATE_SAMPLES * self._period:
            self._then(sample)

    def _pursued(self, sample: Sample) -> None:
        """Setpoints are followed as the drive will, within its limits; in the end it is there."""
        assert self._motion is not None
        into = sample.time_s - self._sent_at
        there = abs(sample.reference - self._motion.at(into)[0]) <= _AT_START_M
        if into > self._motion.end_s and there and abs(sample.velocity) <= STILL_M_S:
            self._then(sample)
        elif into > self._motion.end_s + SETTLE_S:
            self.end("the drive did not come to where its setpoints ended")

    def _finish(self, sample: Sample) -> None:
        """After the motion: its rest recorded, then done."""
        if self._phase != self._finish:
            self._phase, self._since = self._finish, sample.time_s
        assert self._since is not None
        if sample.time_s - self._since > TAIL_S:
            self._recording = self._hearing.finish()
            self._statuses, self._waits_from = len(self._missed), time.monotonic()
            self._phase = self._hear_missed

    def _hear_missed(self, _: Sample) -> None:
        """The motion is recorded; a drive that counts missed ticks tells them once a second."""
        told = not self._missed or len(self._missed) > self._statuses
        if told or time.monotonic() - self._waits_from > STATUS_S:
            self._conclude(at_rest=True)

    # Ends.

    def end(self, why: str) -> None:
        """Bring the drive to rest, for a reason that is told; the first one counts."""
        if self._ended or self.done.done():
            return
        if not self._sent_wall:
            self._fail(why)
            return
        self._ended = why
        self._stopping = time.monotonic()
        if self._last is not None:
            self._stopping_at, self._speed_then = self._last.time_s, abs(self._last.velocity)
        self._phase, self._since = self._stopped, None
        if self._follows == "trajectory":
            self._publishers["trajectory"].publish(_message(self._task.joint, ()))

    def _stopped(self, sample: Sample) -> None:
        """While the drive comes to rest. (On setpoints it does, at the last one.)"""
        if abs(sample.velocity) > STILL_M_S:
            self._since = None
        elif self._since is None:
            self._since = sample.time_s
        elif sample.time_s - self._since > TAIL_S:
            self._conclude(at_rest=True)

    def _stop(self, *, deaf: bool) -> None:
        """Wall time goes on while the drive comes to rest, or is silent."""
        took, last = time.monotonic() - self._stopping, self._last
        # A graph in lockstep on a busy computer takes longer than its own time.
        own = took if last is None else min(took, last.time_s - self._stopping_at)
        if took > DEAF_STOP_S if deaf else own > STOP_S:
            self._conclude(at_rest=False)
        elif took > HOLD_AFTER_S and not self._given_place and last is not None:
            self._given_place = True
            fast = abs(last.velocity)
            slower = fast < 0.9 * self._speed_then or fast <= STILL_M_S
            if self._follows == "trajectory" and not slower:
                # Not every controller takes a trajectory without points for the wish to stop.
                limits = self._task.limits
                time_s = 3.0 * fast / limits.acceleration + 0.1
                place = last.reference + 0.5 * last.velocity * time_s
                place = min(max(place, limits.stroke_min), limits.stroke_max)
                points = (Point(time_s, place, 0.0, 0.0),)
                self._publishers["trajectory"].publish(_message(self._task.joint, points))

    def _conclude(self, *, at_rest: bool) -> None:
        missed = self._missed[-1] - self._missed[0] if self._missed else None
        self.done.set_result(
            Played(
                self._hearing.finish() or self._recording,
                self._samples,
                self._error_m,
                self._current_a,
                self._ended or None,
                at_rest,
                missed,
            )
        )

    def _fail(self, why: str) -> None:
        """The motion has not begun, and nothing is kept."""
        path = self._hearing.finish()
        if path is not None:
            path.unlink(missing_ok=True)
        if not self.done.done():
            self.done.set_result(InputError(why))


def _or_nothing(value: float) -> float:
    return value if value == value else -1.0


def _message(joint: str, points: tuple[Point, ...]) -> JointTrajectory:
    """Points as the message; none: come to rest."""
    return JointTrajectory(
        joint_names=[joint],
        points=[
            JointTrajectoryPoint(
                positions=[one.position],
                velocities=[] if one.velocity is None else [one.velocity],
                accelerations=[] if one.acceleration is None else [one.acceleration],
                time_from_start=Duration(
                    sec=round(one.time_s * wire.NANOSECONDS) // wire.NANOSECONDS,
                    nanosec=round(one.time_s * wire.NANOSECONDS) % wire.NANOSECONDS,
                ),
            )
            for one in points
        ],
    )
