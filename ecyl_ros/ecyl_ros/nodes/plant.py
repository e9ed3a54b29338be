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
from pathlib import Path

import numpy as np
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import Vector3, Vector3Stamped
from rclpy.clock import Clock, ClockType
from rclpy.duration import Duration
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
from . import wire
from .drive_node import DriveNode
from .realtime import TickTiming, run_as_others, run_first, watchdog_ns, with_transport_delay
from .run_node import run_node

START_DELAY_S = 0.5  # real time: from announcing the epoch to the first tick


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
        self._commanded_ns = 0  # real time: stamp of the newest command
        self._watchdog_ns = watchdog_ns(self._rate)
        self.timing = TickTiming(self._rate)

        # Compile, or load from cache, before anybody waits for a tick.
        apply_and_measure(self._state.copy(), self._pending.copy(), 0, self._params, self._measured)
        measure(self._state, 0, self._params, self._measured)
        apply_voltage(self._state.copy(), self._pending.copy(), self._params)

        self._measurement = self.create_publisher(
            JointState, wire.CONTROL_MEASUREMENT, wire.control()
        )
        self._epoch = self.create_publisher(Time, wire.EPOCH, wire.latched())
        # Written anew at every tick, for making messages costs as much as sending them.
        unmeasured = [math.nan] * len(wire.MEASUREMENT_JOINTS)
        self._measurement_message = JointState(
            header=Header(frame_id=wire.BASE_FRAME),
            name=list(wire.MEASUREMENT_JOINTS),
            position=unmeasured,
            velocity=unmeasured,
            effort=unmeasured,
        )
        message = self._measurement_message
        self._measurement_fields = (
            message.header.stamp,
            message.position,
            message.velocity,
            message.effort,
        )
        self._waiting = self.create_publisher(Time, wire.WAITING, 10)
        telemetry = wire.telemetry(self.realtime)
        self._telemetry = self.create_publisher(JointState, wire.JOINT_STATES, telemetry)
        self._telemetry_current = self.create_publisher(Vector3Stamped, wire.CURRENT, telemetry)
        self._clock_publisher = None
        if not self.realtime:
            self._clock_publisher = self.create_publisher(ClockMessage, wire.CLOCK, 10)
        self.create_subscription(
            Vector3Stamped, wire.CONTROL_VOLTAGE, self._on_voltage, wire.control()
        )
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._timer = None
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
            # The timer first, and whole periods to tick 0: so the timer's instants are the ticks'.
            self._timer = self.create_timer(1.0 / self._rate, self._on_timer, clock=self._steady)
            delay = math.ceil(START_DELAY_S * self._rate) / self._rate
            self._started = time.monotonic() + delay
            self._epoch_ns = self.get_clock().now().nanoseconds + round(delay * 1e9)
            self._commanded_ns = self._epoch_ns
            self._epoch.publish(wire.to_time(self._epoch_ns))
            self.timing.start(self._started)
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
        """Say the tick again: controller or reference may have started anew."""
        if self._epoch_ns is not None and not self.realtime:
            self._waiting.publish(wire.to_time(self._stamp_ns))
            self._publish_control()

    # --- ticks ---------------------------------------------------------------------------------

    def _on_voltage(self, message: Vector3Stamped) -> None:
        stamp_ns = wire.to_ns(message.header.stamp)
        if self.realtime:
            self._take_command(stamp_ns, message.vector)
            return
        if stamp_ns != self._stamp_ns or self._finished():
            return  # an answer to a tick that was said twice
        self.heard_partner()
        self._pending[-1, 0] = message.vector.x
        self._pending[-1, 1] = message.vector.y
        self._tick += 1
        apply_and_measure(self._state, self._pending, self._tick, self._params, self._measured)
        if self._finished():
            self._end_run()
        else:
            self._publish_tick()

    def _take_command(self, stamp_ns: int, voltage: Vector3) -> None:
        """Real time: the newest command holds, unless it answers what is long past."""
        if self._stamp_ns - stamp_ns > self._watchdog_ns:
            return  # from a controller that stood still
        self.heard_partner()
        self._command[:] = voltage.x, voltage.y
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
        self.rest(
            f"no voltage on {self.resolve_topic_name(wire.CONTROL_VOLTAGE)} "
            f"for {self._watchdog_ns / wire.NANOSECONDS:g} s: windings shorted until it is back"
        )

    def _finished(self) -> bool:
        return self._last_tick is not None and self._tick >= self._last_tick

    def _on_timer(self) -> None:
        """Real time: advance to the present, tick by tick, and say each tick once."""
        now = time.monotonic()
        due = self.timing.wake(now, self._tick)
        for _ in range(due):
            if self._finished():
                self._end_run()
                return
            if self._tick:
                apply_voltage(self._state, self._pending, self._params)
            self._measure_and_publish()
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

    def _publish_tick(self) -> None:
        self._stamp_ns = tick_stamp_ns(self._tick, self._rate, self._epoch_ns or 0)
        self._publish_control()
        if self._tick % self._every == 0:
            self._publish_telemetry()

    def _publish_control(self) -> None:
        stamp, position, velocity, effort = self._measurement_fields
        stamp.sec, stamp.nanosec = divmod(self._stamp_ns, wire.NANOSECONDS)
        (
            position[0],
            velocity[0],
            position[1],
            velocity[1],
            effort[2],
            effort[3],
            _,
        ) = self._measured.tolist()
        self._measurement.publish(self._measurement_message)

    def _publish_telemetry(self) -> None:
        values = self._measured.tolist()
        stamp = wire.to_time(self._stamp_ns)
        position, velocity, effort = joint_values(
            values, float(self._state[2]), float(self._state[3]), self.drive
        )
        self._telemetry.publish(
            JointState(
                header=Header(stamp=stamp, frame_id=wire.BASE_FRAME),
                name=[wire.ROTOR, wire.ROD, wire.LOAD],
                position=position,
                velocity=velocity,
                effort=effort,
            )
        )
        self._telemetry_current.publish(
            Vector3Stamped(
                header=Header(stamp=stamp, frame_id=wire.DQ_FRAME),
                vector=Vector3(x=values[4], y=values[5], z=0.0),
            )
        )
        if self._clock_publisher is not None:
            self._clock_publisher.publish(ClockMessage(clock=stamp))

    # --- end and figures -----------------------------------------------------------------------

    def on_drive_changed(self, drive: DriveParameters) -> None:
        """Take over changed physics between two ticks, if the loop stays stable."""
        check_stability(drive, "node plant")
        self._params = pack(drive)

    def _end_run(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
        for publisher in (self._measurement, self._telemetry, self._telemetry_current):
            publisher.wait_for_all_acked(Duration(seconds=5.0))
        self.finish(0, f"ran {self.option('duration'):g} s: {self._tick} ticks")

    def _figures(self, timing: dict) -> dict:
        wall = time.monotonic() - self._started if self._started else 0.0
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
        self.report(
            DiagnosticStatus.OK,
            "plant timing",
            "real time" if self.realtime else "lockstep",
            {key: f"{value:.6g}" for key, value in figures.items()},
        )

    def close(self) -> None:
        """Leave the figures of the whole run."""
        if self.realtime:
            run_as_others()
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
