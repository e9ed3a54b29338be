"""What all nodes of the drive share: parameters from the drive file, partners, and an end."""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable, Mapping
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rcl_interfaces.msg import ParameterDescriptor, SetParametersResult
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.task import Future
from std_msgs.msg import Header

from ..drive.drive_file import drive_from_flat, drive_to_flat, key_meaning
from ..drive.parameters import DriveParameters, leaf_fields
from ..errors import InputError
from . import wire
from .scheduling import run_on

WATCH_PERIOD_S = 0.25
LOOK_PERIOD_S = 0.05
SAY_AFTER_S = 5.0
REPORT_PERIOD_S = 1.0

# Parameters every node has beside the drive's: name -> (default, meaning).
COMMON_PARAMETERS: dict[str, tuple[Any, str]] = {
    "realtime": (False, "pace by the wall clock; otherwise in lockstep with the controller"),
    "recorder": ("", "name of a listening node that must be there before a run begins"),
    "processors": ("", "numbers of those to run on, such as 1 or 0,2; empty: any"),
    "partner_timeout": (60.0, "s a node waits for a silent partner before it ends; 0: for ever"),
}


class DriveNode(Node):
    """A node that knows the drive's parameters.

    The parameters of the drive file become parameters of the node, described and checked; unknown
    keys and impossible values end the node with InputError. `live` names the prefixes whose values
    may be changed while running; `on_drive_changed` is then called.

    `done` is a future the node completes, with (exit code, reason), when its work is over.
    """

    live: tuple[str, ...] = ()
    # A node that need not answer at once takes its messages in batches this far apart, s: waking
    # up for each of some thousand messages a second costs more than handling them.
    batch_s: float = 0.0
    # What `DirectExecutor` calls `on_due` for, s on the monotonic clock: rcl's timers run by
    # another clock, which drifts against it. Such a node takes its messages then.
    due_s: float = math.inf
    takes_when_due: bool = False

    def __init__(self, name: str, own: dict[str, tuple[Any, str]], **options: Any) -> None:
        """own: this node's further parameters, name -> (default, meaning)."""
        super().__init__(name, **options)
        self.done: Future = Future()
        self._own = COMMON_PARAMETERS | own
        # Read before declaring: rclpy cannot declare an empty list from a file, and only what
        # was given shows which keys nobody knows.
        given = {key: item.value for key, item in self._parameter_overrides.items()}
        drives = {key: value for key, value in given.items() if key not in self._own}
        self.drive: DriveParameters = drive_from_flat(drives, f"node {name}")
        self._declare(given)
        self._run_on(self.option("processors"))
        self._heard = time.monotonic()
        self.handled = 0  # messages from the partner so far
        self._said = 0.0
        self.resting: str | None = None  # why the drive is kept at rest while the partner is away
        self._reported = 0.0  # s of silence at the last report, 0: none since the partner was heard
        self._diagnostics = self.create_publisher(DiagnosticArray, wire.DIAGNOSTICS, 10)
        self.add_on_set_parameters_callback(self._check_change)
        self._watch = self.create_timer(
            WATCH_PERIOD_S, self._watch_partner, clock=Clock(clock_type=ClockType.STEADY_TIME)
        )

    def _declare(self, given: dict[str, Any]) -> None:
        """Declare every parameter with its meaning and one type, whatever the file wrote."""
        for key, value in drive_to_flat(self.drive).items():
            meaning = key_meaning(key)
            if value == []:
                continue  # ROS has no empty list of numbers; one unset value empties param dumps
            self._declare_one(key, value, meaning)
        for key, (default, meaning) in self._own.items():
            value = given.get(key, default)
            kind = type(default)
            if kind is float and isinstance(value, int) and not isinstance(value, bool):
                value = float(value)
            if type(value) is not kind or (kind is float and not math.isfinite(value)):
                wanted = f"expected {kind.__name__}: {meaning}"
                raise InputError(f"node {self.get_name()}: {key} = {value!r}, {wanted}")
            self._declare_one(key, value, meaning)

    def _declare_one(self, key: str, value: Any, meaning: str) -> None:
        descriptor = ParameterDescriptor(description=meaning)
        self.declare_parameter(key, value, descriptor, ignore_override=True)

    def _run_on(self, numbers: str) -> None:
        if not numbers:
            return
        try:
            run_on({int(number) for number in numbers.split(",")})
        except (ValueError, OSError):
            raise InputError(
                f"node {self.get_name()}: processors = {numbers!r}, expected numbers of "
                "processors of this machine, such as 1 or 0,2"
            ) from None

    def option(self, key: str) -> Any:
        """Value of one of the node's own parameters."""
        return self.get_parameter(key).value

    def _check_change(self, changes: list[Parameter]) -> SetParametersResult:
        leaves = leaf_fields()
        flat = drive_to_flat(self.drive)
        for change in changes:
            if change.name in leaves:
                if not change.name.startswith(self.live):
                    return SetParametersResult(
                        successful=False, reason=f"{change.name} is read at start only"
                    )
                flat[change.name] = change.value
            elif change.name in self._own:
                return SetParametersResult(
                    successful=False, reason=f"{change.name} is read at start only"
                )
        try:
            drive = drive_from_flat(flat, f"node {self.get_name()}")
            if drive != self.drive:
                self.on_drive_changed(drive)
        except InputError as error:
            return SetParametersResult(successful=False, reason=str(error))
        self.drive = drive
        return SetParametersResult(successful=True)

    def on_drive_changed(self, drive: DriveParameters) -> None:
        """Take over changed parameters; raise InputError to refuse them."""

    def is_recorded(self, *topics: str) -> bool:
        """Whether the recorder, if one is wanted, hears all these topics of ours."""
        recorder = self.option("recorder")
        return not recorder or all(
            any(end.node_name == recorder for end in self.get_subscriptions_info_by_topic(topic))
            for topic in map(self.resolve_topic_name, topics)
        )

    def when_recorded(self, topic: str, begin: Callable[[], None]) -> None:
        """Call `begin` as soon as the recorder, if one is wanted, hears `topic`.

        What `begin` creates tells the plant that this node is ready.
        """
        steady = Clock(clock_type=ClockType.STEADY_TIME)

        def look() -> None:
            if self.is_recorded(topic):
                timer.cancel()
                begin()

        timer = self.create_timer(LOOK_PERIOD_S, look, clock=steady)

    def on_due(self) -> None:
        """Called when `due_s` has come; sets the next."""

    def heard_partner(self) -> None:
        """Note that the partner is alive."""
        self.handled += 1
        self._heard = time.monotonic()

    def silent_s(self) -> float:
        """Seconds since the partner was heard."""
        return time.monotonic() - self._heard

    def waiting_for(self) -> str | None:
        """What the node is waiting for, or None when it waits for nobody."""
        return None

    def while_waiting(self) -> None:
        """Called every `WATCH_PERIOD_S` while the partner is silent."""

    def _watch_partner(self) -> None:
        silent = self.silent_s()
        if silent < WATCH_PERIOD_S:
            if self._said:
                self.get_logger().info("heard again, going on")
            if self._reported:
                self._report_partner("heard again")
            self._said = self._reported = 0.0
            return
        partner = self.waiting_for()  # asks the graph: not while all goes well
        if partner is None or self.done.done():
            self._heard = time.monotonic()
            return
        self.while_waiting()
        limit = self.option("partner_timeout")
        if limit and silent > limit:
            self.finish(1, f"gave up waiting for {partner} after {limit:g} s")
        elif silent > max(SAY_AFTER_S, 2.0 * self._said):
            self._said = silent
            self.get_logger().warning(f"waiting for {partner} ({silent:.0f} s)")
        if not self._reported or silent > self._reported + REPORT_PERIOD_S:
            self._reported = silent
            self._report_partner(f"waiting for {partner}", {"silent_s": f"{silent:.3g}"})

    def status_name(self, subject: str) -> str:
        """What a status of this drive is called, by its namespace among several drives."""
        return f"{self.get_namespace()}/ecyl/{subject}".lstrip("/")

    def report(
        self, level: bytes, subject: str, message: str, values: Mapping[str, str] | None = None
    ) -> None:
        """Publish a status of this node on `/diagnostics`; subject: what the status is about."""
        status = DiagnosticStatus(
            level=level,
            name=self.status_name(subject),
            hardware_id=self.get_fully_qualified_name(),
            message=message,
            values=[KeyValue(key=key, value=value) for key, value in (values or {}).items()],
        )
        header = Header(stamp=self.get_clock().now().to_msg())
        self._diagnostics.publish(DiagnosticArray(header=header, status=[status]))

    def _report_partner(self, message: str, values: Mapping[str, str] | None = None) -> None:
        level = DiagnosticStatus.WARN if values else DiagnosticStatus.OK
        if self.resting is not None:
            level, message = DiagnosticStatus.ERROR, self.resting
        self.report(level, f"{self.get_name()} partner", message, values)

    def rest(self, why: str) -> None:
        """Say that the drive is brought to rest for want of the partner, and why."""
        self.resting = why
        self.get_logger().error(why)
        self._report_partner(why)

    def end_rest(self, why: str) -> None:
        """Say that the partner is back."""
        self.resting = None
        self.get_logger().warning(f"{why}, going on")
        self._report_partner(why)

    def refuse(self, topic: str, error: Exception) -> None:
        """Say that a message on `topic` was unusable, and why."""
        self.get_logger().error(
            f"a message on {self.resolve_topic_name(topic)} was left out: {error}",
            throttle_duration_sec=1.0,
        )

    def last_words(self, text: str) -> None:
        """Warn from within `close`; once a signal has shut the context down, on stderr alone."""
        if self.context.ok():
            self.get_logger().warning(text)
        else:
            print(f"[WARN] [{self.get_name()}]: {text}", file=sys.stderr)

    def finish(self, code: int, reason: str) -> None:
        """End the node: its main function returns `code` after logging `reason`."""
        if not self.done.done():
            (self.get_logger().error if code else self.get_logger().info)(reason)
            self.done.set_result((code, reason))

    def close(self) -> None:
        """Put away what the node holds; called once after spinning, whatever ended it."""
