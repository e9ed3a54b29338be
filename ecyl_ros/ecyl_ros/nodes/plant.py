"""The plant node: motor, transmission and load, stepped by the controller's commands.

Lockstep: a tick's measurement goes out, the plant advances when the command for that tick has come.
Real time: a wall timer sets the pace, the last command is held, late and stale ticks are counted;
where no command comes any more, the inverter shorts the windings.
"""

from __future__ import annotations

import json
import math
import os
import time
from collections import deque
from pathlib import Path

import numpy as np
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import Vector3Stamped
from rclpy.clock import Clock, ClockType
from rclpy.duration import Duration
from rclpy.timer import Timer
from rosgraph_msgs.msg import Clock as ClockMessage
from sensor_msgs.msg import JointState
from std_msgs.msg import Header

from ..drive.engine import tick_count
from ..drive.packed import pack
from ..drive.parameters import DriveParameters
from ..drive.plant import (
    MEASURED,
    apply_and_measure,
    apply_voltage,
    initial_state,
    measure,
    voltage_queue,
)
from ..drive.stability import check_stability
from ..drive.telemetry import joint_values, tick_stamp_ns
from ..recording.cdr import CdrError
from ..recording.topics import JOINT_FIELDS
from . import wire
from .compiling import compiling
from .direct_executor import DirectExecutor
from .drive_node import DriveNode
from .ready_bytes import Incoming, Outgoing
from .realtime import FEW_MISSED, TickTiming, watchdog_ns, with_transport_delay
from .run_node import run_node
from .scheduling import Awake, run_as_others, run_first

START_DELAY_S = 0.5  # real time: from announcing the epoch to the first tick
# Real time: one loss of voltage may be a controller restarted, a second one the same mishap;
# a third one soon after says that the machine does not hold the rate.
LOSSES = 3
LOSSES_S = 10.0
AT_REST_S = 0.5  # shorted windings brake the motor for so long before the run is ended
_TELEMETRY_FIELDS = [
    f"{joint}.{field}" for field in JOINT_FIELDS for joint in wire.TELEMETRY_JOINTS
]


def _joints(names: tuple[str, ...]) -> JointState:
    """A message of these joints in which nothing is measured."""
    nothing = [math.nan] * len(names)
    header = Header(frame_id=wire.BASE_FRAME)
    return JointState(
        header=header, name=list(names), position=nothing, velocity=nothing, effort=nothing
    )


class Plant(DriveNode):
    """Publishes measurements, takes voltages, keeps the run's time."""

    live = ("motor.", "transmission.", "load.")

    def __init__(self, **options) -> None:
        super().__init__(
            "plant",
            {
                "duration": (0.0, "s to run; 0: until stopped"),
                "summary_file": ("", "JSON file to write the run's figures to at the end"),
            },
            **options,
        )
        self.realtime: bool = self.option("realtime")
        if self.realtime:
            self.drive = with_transport_delay(self.drive, self.get_logger())
        check_stability(self.drive, "node plant")
        duration = self.option("duration")
        self._last_tick = tick_count(self.drive, duration) if duration else None
        self._every = self.drive.telemetry_every
        self._rate = self.drive.controller.rate
        self._params = pack(self.drive)
        self._state = initial_state()
        # Voltages on their way to the inverter, the oldest first. In real time the newest command
        # waits in `_command` until the next tick takes it over: that is one of the delay's ticks.
        queue = voltage_queue(self._params)
        self._pending = queue[1:] if self.realtime else queue
        self._command = np.zeros(2)
        self._measured = np.zeros(len(MEASURED))
        self._tick = 0
        self._stamp_ns = 0
        self._previous_ns = -1
        self._epoch_ns: int | None = None
        self._started = 0.0
        self._awake: Awake | None = None
        self._ended: float | None = None  # without the wait for those who lag behind
        self._commanded_ns = 0  # real time: stamp of the newest command
        self._watchdog_ns = watchdog_ns(self._rate)
        self._losses: deque[int] = deque(maxlen=LOSSES)  # ticks at which the voltage stayed away
        self._given_up: int | None = None  # tick at which a run under overload ends
        self._overload = ""
        self.takes_when_due = self.realtime
        self.timing = TickTiming(self._rate)

        with compiling(self):  # before anybody waits for a tick
            trial = self._state.copy()
            apply_and_measure(trial, self._pending.copy(), 0, self._params, self._measured)
            measure(self._state, 0, self._params, self._measured)
            apply_voltage(self._state.copy(), self._pending.copy(), self._params)

        self._measurement = self.create_publisher(
            JointState, wire.CONTROL_MEASUREMENT, wire.control()
        )
        self._epoch = self.create_publisher(Time, wire.EPOCH, wire.latched())
        self._measurement_bytes = Outgoing(
            _joints(wire.MEASUREMENT_JOINTS), *wire.MEASUREMENT_FIELDS
        )
        self._joint_bytes = Outgoing(_joints(wire.TELEMETRY_JOINTS), *_TELEMETRY_FIELDS)
        self._current_bytes = Outgoing(
            Vector3Stamped(header=Header(frame_id=wire.DQ_FRAME)), *wire.VECTOR_DQ
        )
        self._waiting = self.create_publisher(Time, wire.WAITING, 10)
        telemetry = wire.telemetry(self.realtime)
        self._telemetry = self.create_publisher(JointState, wire.JOINT_STATES, telemetry)
        self._telemetry_current = self.create_publisher(Vector3Stamped, wire.CURRENT, telemetry)
        self._clock_publisher = None
        if not self.realtime:
            self._clock_publisher = self.create_publisher(ClockMessage, wire.CLOCK, 10)
        self._voltage = Incoming(Vector3Stamped, *wire.VECTOR_DQ)
        self.create_subscription(
            Vector3Stamped,
            wire.CONTROL_VOLTAGE,
            self._on_voltage,
            wire.control(self.realtime),
            raw=True,
        )
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._timer: Timer | None = None
        self._steady = steady
        self._start_timer = self.create_timer(0.05, self._try_start, clock=steady)
        # Half a second apart: together they would take as long as a tick has at 1 kHz.
        self._progress_due = False
        self.create_timer(0.5, self._report_progress, clock=steady)

    # --- start ---------------------------------------------------------------------------------

    def _partners_missing(self) -> str | None:
        # Who has begun stays; who comes second goes.
        if self._epoch_ns is None and self.count_publishers(wire.CONTROL_MEASUREMENT) > 1:
            self.finish(
                2,
                f"another plant publishes {self.resolve_topic_name(wire.CONTROL_MEASUREMENT)}; "
                "expected one drive per ROS domain and namespace",
            )
        if not self.count_subscribers(wire.CONTROL_MEASUREMENT):
            return "a controller"
        if not self.count_publishers(wire.CONTROL_VOLTAGE):
            return "the controller's voltage"
        if not self.count_publishers(wire.CONTROL_REFERENCE):
            return "a reference"
        if not self.is_recorded(wire.JOINT_STATES, wire.CURRENT):
            return "the recorder"
        return None

    def _try_start(self) -> None:
        if self._partners_missing() is not None or self.done.done():
            return
        self._start_timer.cancel()
        if self.realtime:
            self._started = self._pace()
            delay = self._started - time.monotonic()
            self._epoch_ns = self.get_clock().now().nanoseconds + round(delay * 1e9)
            self._commanded_ns = self._epoch_ns
            self._epoch.publish(wire.to_time(self._epoch_ns))
            self.timing.start(self._started)
            self._awake = Awake()
            if not run_first():
                self.get_logger().warning(
                    "the kernel gives no real-time priority (see ulimit -r): ticks will be late "
                    "when the machine is busy"
                )
        else:
            self._epoch_ns = 0
            self._started = time.monotonic()
            self._epoch.publish(wire.to_time(0))
            self._measure_and_publish()
        self.heard_partner()

    def _pace(self) -> float:
        """Have the ticks called from some time on; when tick 0 is, s on the monotonic clock."""
        if isinstance(self.executor, DirectExecutor):
            self.due_s = time.monotonic() + START_DELAY_S
            return self.due_s
        # Whole periods from the timer's first call to tick 0: so its instants are the ticks'.
        timer = self.create_timer(1.0 / self._rate, self._on_timer, clock=self._steady)
        self._timer = timer
        first = time.monotonic() + 1e-9 * (timer.time_until_next_call() or 0)
        return first + math.ceil(START_DELAY_S * self._rate) / self._rate

    def on_due(self) -> None:
        """Real time: a tick is due."""
        self._on_timer()
        self.due_s = self._started + self._tick / self._rate

    def waiting_for(self) -> str | None:
        """The controller or reference until they are there, then the command.

        In lockstep the plant waits after every tick, in real time when none came for long.
        """
        if self._epoch_ns is None:
            return self._partners_missing()
        if self.realtime and self.resting is None:
            return None
        missing = self._partners_missing()
        return missing or "a command on " + self.resolve_topic_name(wire.CONTROL_VOLTAGE)

    def while_waiting(self) -> None:
        """Say the tick again: controller or reference may have restarted."""
        if self._epoch_ns is not None and not self.realtime:
            self._waiting.publish(wire.to_time(self._stamp_ns))
            self._publish_control()

    # --- ticks ---------------------------------------------------------------------------------

    def _on_voltage(self, data: bytes) -> None:
        try:
            stamp_ns, voltage = self._voltage.unpack(data)
        except CdrError as error:
            self.refuse(wire.CONTROL_VOLTAGE, error)
            return
        if self.realtime:
            self._take_command(stamp_ns, voltage)
            return
        if stamp_ns != self._stamp_ns or self._finished():
            return  # an answer to a tick that was said twice
        self.heard_partner()
        self._pending[-1] = voltage
        self._tick += 1
        apply_and_measure(self._state, self._pending, self._tick, self._params, self._measured)
        if self._finished():
            self._end_run()
        else:
            self._publish_tick()

    def _take_command(self, stamp_ns: int, voltage: list[float]) -> None:
        """Real time: the newest command holds, unless it answers what is long past."""
        # At rest only what is clearly in time ends the rest: the next loss would follow at once.
        oldest_ns = self._watchdog_ns if self.resting is None else self._watchdog_ns // 2
        if self._stamp_ns - stamp_ns > oldest_ns or self._given_up is not None:
            return  # from a controller that stood still, or for a drive that is to stay at rest
        self.heard_partner()
        self._command[:] = voltage
        self._commanded_ns = stamp_ns
        self.timing.command(stamp_ns)
        if self.resting is not None:
            self.end_rest("the controller's voltage is back")

    def _short_windings(self) -> None:
        """Real time, no command: 0 V on both axes, so that the motor brakes by its own voltage.

        Holding the last voltage would drive the rod on, an open bridge would let it coast.
        """
        self._command[:] = 0.0
        self.timing.shorted += 1
        self._losses.append(self._tick)
        if len(self._losses) == LOSSES and self._tick - self._losses[0] < LOSSES_S * self._rate:
            silence_s = self._watchdog_ns / wire.NANOSECONDS
            self._give_up(f"{LOSSES} times within {LOSSES_S:g} s no voltage for {silence_s:g} s")
            return
        self.rest(
            f"no voltage on {self.resolve_topic_name(wire.CONTROL_VOLTAGE)} "
            f"for {self._watchdog_ns / wire.NANOSECONDS:g} s: windings shorted until it is back"
        )

    def _give_up(self, why: str) -> None:
        """Overload: bring the drive to rest, and end the run then."""
        self._command[:] = 0.0
        self._given_up = self._tick + math.ceil(AT_REST_S * self._rate)
        self._overload = (
            f"overload: {why}; expected a lower controller.rate than {self._rate:g} Hz, or a "
            "machine with less other work"
        )
        self.rest(f"{self._overload}: windings shorted, the run ends")

    def _finished(self) -> bool:
        return self._last_tick is not None and self._tick >= self._last_tick

    def _on_timer(self) -> None:
        """Real time: advance to the present, tick by tick, and ask for the last tick's voltage.

        What the ticks before it would be answered with came too late for them.
        """
        due = self.timing.wake(time.monotonic(), self._tick)
        for left in range(due, 0, -1):
            if self._finished():
                self._end_run()
                return
            if self._given_up is not None and self._tick >= self._given_up:
                self.finish(1, self._overload)
                return
            if self._tick:
                apply_voltage(self._state, self._pending, self._params)
            measure(self._state, self._tick, self._params, self._measured)
            self._publish_tick(ask=left == 1)
            # The command of the tick before is due now; one that comes later acts a tick later.
            self.timing.latch(self._previous_ns)
            self._previous_ns = self._stamp_ns
            if self._stamp_ns - self._commanded_ns > self._watchdog_ns and self.resting is None:
                self._short_windings()
            self._pending[-1] = self._command
            self._tick += 1

    def _measure_and_publish(self) -> None:
        measure(self._state, self._tick, self._params, self._measured)
        self._publish_tick()

    def _publish_tick(self, ask: bool = True) -> None:
        """ask: whether a voltage is wanted for this tick."""
        self._stamp_ns = tick_stamp_ns(self._tick, self._rate, self._epoch_ns or 0)
        if ask:
            self._publish_control()
        if self._tick % self._every == 0:
            self._publish_telemetry()

    def _publish_control(self) -> None:
        *numbers, _ = self._measured.tolist()
        self._measurement.publish(self._measurement_bytes.pack(self._stamp_ns, numbers))

    def _publish_telemetry(self) -> None:
        values = self._measured.tolist()
        position, velocity, effort = joint_values(
            values, float(self._state[2]), float(self._state[3]), self.drive
        )
        joints = self._joint_bytes.pack(self._stamp_ns, [*position, *velocity, *effort])
        self._telemetry.publish(joints)
        self._telemetry_current.publish(self._current_bytes.pack(self._stamp_ns, values[4:6]))
        if self._clock_publisher is not None:
            self._clock_publisher.publish(ClockMessage(clock=wire.to_time(self._stamp_ns)))

    # --- end and figures -----------------------------------------------------------------------

    def on_drive_changed(self, drive: DriveParameters) -> None:
        """Take over changed physics between two ticks, if the loop stays stable."""
        check_stability(drive, "node plant")
        self._params = pack(drive)

    def _end_run(self) -> None:
        self.due_s = math.inf
        self._ended = time.monotonic()
        if self._timer is not None:
            self._timer.cancel()
        for publisher in (self._measurement, self._telemetry, self._telemetry_current):
            publisher.wait_for_all_acked(Duration(seconds=5.0))
        self.finish(0, f"ran {self.option('duration'):g} s: {self._tick} ticks")

    def _figures(self, timing: dict) -> dict:
        now = time.monotonic() if self._ended is None else self._ended
        wall = now - self._started if self._started else 0.0
        return {
            "realtime": self.realtime,
            "ticks": self._tick,
            "samples": -(-self._tick // self._every),
            "wall_s": wall,
            "ticks_per_s": self._tick / wall if wall > 0 else 0.0,
        } | timing

    def _report_progress(self) -> None:
        """Figures on `/diagnostics` and, half a second later, in the summary file, by turns."""
        if not self._tick:
            return
        self._progress_due = not self._progress_due
        figures = self._figures(self.timing.running_figures(self._tick) if self.realtime else {})
        if self._progress_due:
            self._write_summary(figures)
            return
        level, message = DiagnosticStatus.OK, "lockstep"
        if self.realtime:
            share, message = self.timing.since_last(self._tick), "real time"
            if share > FEW_MISSED:
                level = DiagnosticStatus.WARN
                message = f"real time: {share:.1%} of the latest ticks were missed"
            if (too_many := self.timing.too_many()) and self._given_up is None:
                self._give_up(too_many)
        self.report(
            level,
            "plant timing",
            message,
            {key: f"{value:.6g}" for key, value in figures.items()},
        )

    def close(self) -> None:
        """Leave the figures of the whole run."""
        if self.realtime:
            run_as_others()
            if self._awake is not None:
                self._awake.end()
        self._write_summary(self._figures(self.timing.figures(self._tick) if self.realtime else {}))

    def _write_summary(self, figures: dict) -> None:
        """The summary file, whole or not at all."""
        target = self.option("summary_file")
        if target:
            partial = Path(f"{target}.partial")
            partial.write_text(json.dumps(figures), encoding="utf-8")
            os.replace(partial, target)


def main(args: list[str] | None = None) -> int:
    """Entry point of `plant`."""
    return run_node(Plant, args)
