"""The controller node: position, speed and current loop, one voltage per measurement."""

from __future__ import annotations

from collections import deque

import numpy as np
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Vector3Stamped
from rclpy.publisher import Publisher
from sensor_msgs.msg import JointState
from std_msgs.msg import Header

from ..drive.cascade import CascadeState, cascade_tick, initial_cascade_state, looks_back
from ..drive.packed import pack
from ..drive.parameters import DriveParameters
from ..drive.plant import MEASURED
from ..drive.stability import check_stability
from ..drive.telemetry import tick_stamp_ns
from ..errors import InputError
from ..recording.cdr import CdrError
from . import wire
from .compiling import compiling
from .drive_node import DriveNode
from .ready_bytes import Incoming, Outgoing
from .realtime import watchdog_ns, with_transport_delay
from .run_node import run_node
from .scheduling import run_as_others, run_first

BUFFERED_REFERENCES = 4096
BUFFERED_TICKS = 1024


class Controller(DriveNode):
    """Answers every measurement of the plant with a voltage, once the reference for it is there."""

    live = ("controller.",)

    def __init__(self, **options) -> None:
        super().__init__("controller", {}, **options)
        self.realtime: bool = self.option("realtime")
        if self.realtime:
            self.drive = with_transport_delay(self.drive, self.get_logger())
        check_stability(self.drive, "node controller")
        self._rate = self.drive.controller.rate
        self._every = self.drive.telemetry_every
        self._params = pack(self.drive)
        self._state = initial_cascade_state(self._params)
        self._measured = np.zeros(len(MEASURED))
        self._voltage = np.zeros(2)
        self._before, self._after = np.zeros(2), np.zeros(2)
        self._before_ns: int | None = None
        self._after_ns: int | None = None
        self._references: deque[tuple[int, float, float]] = deque(maxlen=BUFFERED_REFERENCES)
        self._last_reference_ns = -1
        self._longest_ns = round(1.5 * wire.NANOSECONDS / self.drive.sample_rate)
        self._measurements: deque[tuple[int, list[float]]] = deque(maxlen=BUFFERED_TICKS)
        self._answered_ns = -1
        self._watchdog_ns = watchdog_ns(self._rate)
        self._epoch_ns: int | None = None  # real time: stamp of tick 0, once it is known
        self.unreferenced = 0  # real time: ticks for which no reference had come
        self.skipped = 0  # real time: ticks that were over before they could be answered
        self._unreferenced_seen = 0

        scratch = initial_cascade_state(self._params)
        with compiling(self):  # before the first tick
            self._run_cascade(scratch, 0.0)

        self._telemetry = self.create_publisher(
            Vector3Stamped, wire.VOLTAGE, wire.telemetry(self.realtime)
        )
        self._commands: Publisher | None = None  # there when we are ready
        self._voltage_bytes = Outgoing(
            Vector3Stamped(header=Header(frame_id=wire.DQ_FRAME)), *wire.VECTOR_DQ
        )
        self.when_recorded(wire.VOLTAGE, self._be_ready)
        self.create_subscription(
            JointState,
            wire.CONTROL_REFERENCE,
            self._on_reference,
            wire.latched(BUFFERED_REFERENCES),
        )
        self._measurement = Incoming(JointState, *wire.MEASUREMENT_FIELDS)
        self.create_subscription(
            JointState,
            wire.CONTROL_MEASUREMENT,
            self._on_measurement,
            wire.control(self.realtime),
            raw=True,
        )
        if self.realtime:
            self.create_subscription(Time, wire.EPOCH, self._on_epoch, wire.latched())

    def _be_ready(self) -> None:
        self._commands = self.create_publisher(Vector3Stamped, wire.CONTROL_VOLTAGE, wire.control())

    # --- reference -----------------------------------------------------------------------------

    def _on_reference(self, message: JointState) -> None:
        stamp_ns = wire.to_ns(message.header.stamp)
        if stamp_ns <= self._last_reference_ns:
            # The reference took back what it had said from here on, or began again.
            while self._references and self._references[-1][0] >= stamp_ns:
                self._references.pop()
            if self._after_ns is not None and self._after_ns >= stamp_ns:
                self._after_ns = None
        self._last_reference_ns = stamp_ns
        velocity = message.velocity[0] if len(message.velocity) else float("nan")
        self._references.append((stamp_ns, message.position[0], velocity))
        if self._measurements:
            self._answer()

    def _bracket(self, stamp_ns: int) -> bool:
        """Bring the reference samples around `stamp_ns` in place; False if they are not there."""
        while self._references and (self._after_ns is None or self._after_ns <= stamp_ns):
            if self._after_ns is not None:
                self._before[:] = self._after
                self._before_ns = self._after_ns
            self._after_ns, self._after[0], self._after[1] = self._references.popleft()
        if self._before_ns is None or self._after_ns is None:
            return False
        if self._after_ns - self._before_ns > self._longest_ns:
            return False  # a reference that began again further on
        return self._before_ns <= stamp_ns < self._after_ns

    # --- measurement ---------------------------------------------------------------------------

    def _on_epoch(self, message: Time) -> None:
        self._epoch_ns = wire.to_ns(message)

    def _on_measurement(self, data: bytes) -> None:
        try:
            stamp_ns, numbers = self._measurement.unpack(data)
        except CdrError as error:
            self.refuse(wire.CONTROL_MEASUREMENT, error)
            return
        if self._measurements and stamp_ns <= self._measurements[-1][0]:
            if stamp_ns == self._measurements[-1][0]:
                return  # said again while it waits here
            self._measurements.clear()  # the plant restarted
        self._measurements.append((stamp_ns, numbers))
        self._answer()

    def _answer(self) -> None:
        """Publish the voltage for every measurement for which the reference has come."""
        while self._measurements and self._answer_one(*self._measurements[0]):
            self._measurements.popleft()

    def _answer_one(self, stamp_ns: int, numbers: list[float]) -> bool:
        """Answer one measurement; False if it has to wait for its reference."""
        if stamp_ns == self._answered_ns:  # said again: the answer may have been lost
            self._publish(stamp_ns)
            return True
        if stamp_ns < self._answered_ns:
            self.get_logger().info("the plant restarted: integrals reset")
            self._state = initial_cascade_state(self._params)
            self._before_ns = None
        elif self.realtime and stamp_ns - self._answered_ns > self._watchdog_ns:
            # Meanwhile the plant went its own way.
            self._state = initial_cascade_state(self._params)
        phase = 0.0
        if self._bracket(stamp_ns) and self._before_ns is not None:
            ticks = round((stamp_ns - self._before_ns) * self._rate / wire.NANOSECONDS)
            phase = ticks / self._every
            self.heard_partner()
            if self.resting is not None:
                self.end_rest("the reference is back")
        elif not self.realtime:
            self.heard_partner()
            return False  # lockstep waits for the reference
        else:
            self.unreferenced += 1
            if self._before_ns is None or self._after_ns is None:
                return True  # nothing to hold yet
            if stamp_ns - self._after_ns > self._watchdog_ns and self.resting is None:
                self._halt()
        self._measured[: len(numbers)] = numbers
        held = self._voltage.tolist()
        self._run_cascade(self._state, phase)
        first = self._answered_ns < 0
        if self.realtime:
            self._publish_in_time(stamp_ns, held)
        else:
            self._publish(stamp_ns, telemetry=phase == 0.0)
        self._answered_ns = stamp_ns
        if first:
            if self.realtime:
                run_first()  # where the kernel refuses, the plant says so
            self.get_logger().info("first measurement answered")
        return True

    def _halt(self) -> None:
        """Real time, no reference: hold the rod where it was to be last."""
        self._before[:] = self._after[0], 0.0
        self._after[1] = 0.0
        self.rest(
            f"no reference on {self.resolve_topic_name(wire.CONTROL_REFERENCE)} "
            f"for {self._watchdog_ns / wire.NANOSECONDS:g} s: position held until it is back"
        )

    def _run_cascade(self, state: CascadeState, phase: float) -> None:
        cascade_tick(
            state,
            self._before,
            self._after,
            phase,
            self._every,
            self._measured,
            self._params,
            self._voltage,
        )

    def _publish_in_time(self, stamp_ns: int, held: list[float]) -> None:
        """Real time: the answer, and as telemetry what was held at samples left out since the last.

        Samples further back than the watchdog's time are not made up for.
        """
        if self._epoch_ns is None:
            self._publish(stamp_ns)  # a plant that has said no epoch: nothing to be in step with
            return
        tick = round((stamp_ns - self._epoch_ns) * self._rate / wire.NANOSECONDS)
        first = tick
        if 0 <= stamp_ns - self._answered_ns <= self._watchdog_ns:
            answered = (self._answered_ns - self._epoch_ns) * self._rate / wire.NANOSECONDS
            first = round(answered) + 1
            self.skipped += tick - first
        for sample in range(-(-first // self._every), -(-tick // self._every)):
            instant_ns = tick_stamp_ns(sample * self._every, self._rate, self._epoch_ns)
            self._telemetry.publish(self._voltage_bytes.pack(instant_ns, held))
        self._publish(stamp_ns, telemetry=tick % self._every == 0)

    def _publish(self, stamp_ns: int, telemetry: bool = False) -> None:
        message = self._voltage_bytes.pack(stamp_ns, self._voltage.tolist())
        if self._commands is not None:
            self._commands.publish(message)
        if telemetry:
            self._telemetry.publish(message)

    # --- partners and parameters ---------------------------------------------------------------

    def waiting_for(self) -> str | None:
        """The reference while a measurement waits for it or went without, otherwise the plant."""
        unreferenced, self._unreferenced_seen = self._unreferenced_seen, self.unreferenced
        if self._measurements or self.unreferenced > unreferenced:
            return "a reference on " + self.resolve_topic_name(wire.CONTROL_REFERENCE)
        return "a plant on " + self.resolve_topic_name(wire.CONTROL_MEASUREMENT)

    def on_drive_changed(self, drive: DriveParameters) -> None:
        """Take over changed gains and limits between two ticks, if the loop stays stable."""
        fixed = ("rate", "delay_ticks", "structure", "speed_source")
        for key in fixed:
            if getattr(drive.controller, key) != getattr(self.drive.controller, key):
                raise InputError(f"controller.{key} is read at start only")
        check_stability(drive, "node controller")
        params = pack(drive)
        if looks_back(params) and self._state[2] is None:
            # Other code would have to be compiled while the drive moves.
            raise InputError(
                "the cascade began without filter, acceleration feedforward or derivative gain; "
                "expected one of them in the drive file to change them while it runs"
            )
        self._params = params

    def close(self) -> None:
        """Say what a real-time run was short of."""
        if self.realtime:
            run_as_others()
        if self.unreferenced:
            self.last_words(f"{self.unreferenced} ticks without a reference: the last one was held")
        if self.skipped:
            self.last_words(
                f"{self.skipped} ticks were over before they were answered: the voltage was held"
            )


def main(args: list[str] | None = None) -> int:
    """Entry point of `controller`."""
    return run_node(Controller, args)
