"""How long a measurement takes to another process and its voltage back, on this machine, now.

Two nodes of their own answer each other for a moment, with messages as long as the control wire's,
on the executor and the processors that plant and controller will have, at the control rate; at a
faster one where that would take long. What they need tells whether a drive can run in real time.
"""

from __future__ import annotations

import argparse
import json
import math
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

from ..errors import InputError

if TYPE_CHECKING:
    from ..drive.parameters import DriveParameters

DEFAULT_RATE = 1000.0  # Hz, where no drive is asked about
SECONDS = 1.5  # of measuring: 1500 trips at 1 kHz, fifteen of them beyond the 99th percentile
FASTEST = 2000.0  # Hz: nothing is gained by asking again before the answer is there
LEAST = 200  # trips: a drive too slow for as many is measured faster than it ticks
LOST_S = 0.5  # a trip that takes longer is restarted
PATIENCE_S = 30.0  # for both processes to start and find each other
# Of a tick, what 99 of 100 round trips may take: the rest is for computing, for the other nodes
# and for the rarer trips that take longer.
SHARE = 1.0 / 3.0


@dataclass(frozen=True)
class RoundTrip:
    """What was measured: median and 99th percentile of a trip, s, and over which middleware."""

    median_s: float
    p99_s: float
    middleware: str
    together: bool  # both nodes in one process

    def __str__(self) -> str:
        where = "within one process" if self.together else "between two processes"
        return (
            f"round trip {where} over {self.middleware}: median {1e6 * self.median_s:.0f} us, "
            f"99 of 100 within {1e6 * self.p99_s:.0f} us"
        )

    @property
    def rate(self) -> float:
        """Highest control rate, Hz, that leaves each tick time enough; two figures of it."""
        most = SHARE / self.p99_s
        step = 10.0 ** (math.floor(math.log10(most)) - 1)
        return math.floor(most / step) * step


def check_real_time(drive: DriveParameters, source: str, trip: RoundTrip) -> None:
    """Raise InputError, with the rate that would hold, where the drive's asks for too much.

    drive: with the delay it will have. source: what the message calls it.
    """
    from ..drive.stability import smallest_stable_rate

    rate = drive.controller.rate
    if trip.p99_s <= SHARE / rate:
        return
    least = smallest_stable_rate(drive)
    way = f"--rate {trip.rate:g} (rate:={trip.rate:g} of a launch file)"
    if least is None or least > trip.rate:
        need = "no rate does" if least is None else f"they need {math.ceil(least)} Hz"
        way = f"other gains, for with these {need}"
    fewer = "" if trip.together else ", fewer processes (ecyl run --in-process)"
    raise InputError(
        f"{source}: controller.rate = {rate:g} Hz leaves a round trip {1e6 * SHARE / rate:.0f} us "
        f"in real time, a third of a tick; {trip}; expected at most {trip.rate:g} Hz here: {way}"
        f"{fewer}, a machine with less other work, or lockstep (without --realtime)"
    )


def require_real_time(drive: DriveParameters, source: str, *, together: bool = False) -> RoundTrip:
    """What this machine holds; raises InputError where the drive asks for more, see above."""
    from .realtime import with_transport_delay

    drive = with_transport_delay(drive)
    trip = measure(drive.controller.rate, together=together)
    check_real_time(drive, source, trip)
    return trip


def measure(rate: float, *, together: bool = False) -> RoundTrip:
    """Measure at a control rate, Hz, in new processes placed as the launcher places them.

    together: within one process, as all nodes will be. Takes two or three seconds. Raises
    InputError if no message came back.
    """
    from .launcher import FIRST, prepare_child, processors

    topic = f"ecyl/round_trip/p{time.time_ns()}"
    here = set() if together else processors(FIRST[0])
    start = partial(
        subprocess.Popen,
        stdout=subprocess.PIPE,
        start_new_session=True,
        preexec_fn=partial(prepare_child, 0, here),
        text=True,
    )
    command = [sys.executable, "-m", __name__, topic]
    roles = ("both",) if together else ("echo", "ping")
    running: list[subprocess.Popen] = []
    try:
        for role in roles:
            running.append(start([*command, role, str(rate)]))
        text, _ = running[-1].communicate(timeout=2 * PATIENCE_S)
    except subprocess.TimeoutExpired:
        text = ""
    finally:
        for process in running:
            process.kill()
            process.wait()
            if process.stdout is not None:
                process.stdout.close()
    try:
        return RoundTrip(**json.loads(text), together=together)
    except ValueError:
        raise InputError(
            "no message came back while the round trip was measured; expected DDS on this machine "
            "to reach another process (see ROS_DOMAIN_ID, RMW_IMPLEMENTATION)"
        ) from None


def _echo(node: Any, topic: str) -> None:
    """Answer every measurement with a voltage."""
    from geometry_msgs.msg import Vector3Stamped
    from sensor_msgs.msg import JointState

    from . import wire
    from .ready_bytes import Incoming, Outgoing

    measurement = Incoming(JointState, *wire.MEASUREMENT_FIELDS)
    voltage = Outgoing(Vector3Stamped(), *wire.VECTOR_DQ)
    publisher = node.create_publisher(Vector3Stamped, f"{topic}/back", wire.control(True))

    def answer(data: bytes) -> None:
        stamp_ns, numbers = measurement.unpack(data)
        publisher.publish(voltage.pack(stamp_ns, numbers))

    node.create_subscription(JointState, topic, answer, wire.control(True), raw=True)


class _Ping:
    """Sends a measurement a tick and notes how long its voltage takes."""

    def __init__(self, node: Any, topic: str, rate: float) -> None:
        from geometry_msgs.msg import Vector3Stamped
        from rclpy.clock import Clock, ClockType
        from rclpy.task import Future
        from sensor_msgs.msg import JointState

        from . import wire
        from .ready_bytes import Incoming, Outgoing

        nothing = [0.0] * len(wire.MEASUREMENT_JOINTS)
        message = JointState(
            name=list(wire.MEASUREMENT_JOINTS), position=nothing, velocity=nothing, effort=nothing
        )
        self._measurement = Outgoing(message, *wire.MEASUREMENT_FIELDS)
        self._voltage = Incoming(Vector3Stamped, *wire.VECTOR_DQ)
        self._publisher = node.create_publisher(JointState, topic, wire.control(True))
        node.create_subscription(
            Vector3Stamped, f"{topic}/back", self._heard, wire.control(True), raw=True
        )
        pace = min(max(rate, LEAST / SECONDS), FASTEST)
        node.create_timer(1.0 / pace, self._send, clock=Clock(clock_type=ClockType.STEADY_TIME))
        self._wanted = round(pace * SECONDS)
        self._number = 0
        self._sent: float | None = None
        self._end = math.inf
        self.took: list[float] = []
        self.done: Future = Future()

    def _send(self) -> None:
        now = time.perf_counter()
        if self._sent is not None and now - self._sent < LOST_S:
            return  # still under way
        self._number += 1
        self._sent = now
        self._publisher.publish(self._measurement.pack(self._number, [0.0] * 6))

    def _heard(self, data: bytes) -> None:
        now = time.perf_counter()
        if self._sent is None or self._voltage.unpack(data)[0] != self._number:
            return
        if math.isinf(self._end):
            self._end = now + 4.0 * SECONDS  # a slow machine gets fewer trips
        elif len(self.took) < self._wanted and (now < self._end or len(self.took) < LEAST):
            self.took.append(now - self._sent)
        elif not self.done.done():
            self.done.set_result(None)
        self._sent = None


def main(argv: Sequence[str] | None = None) -> int:
    """`ros2 run ecyl_ros round_trip [D.yaml]`: print what this machine holds; 2 if D needs more."""
    from ..drive.drive_file import load_drive, resolve_drive, with_rate

    parser = argparse.ArgumentParser(prog="round_trip", description=main.__doc__)
    parser.add_argument("drive", nargs="?", metavar="D.yaml", help="drive file, or a profile")
    parser.add_argument("--rate", type=float, metavar="HZ", help="instead of the drive file's")
    parser.add_argument("--in-process", action="store_true", help="both nodes in one process")
    options = parser.parse_args(argv)
    try:
        path = None if options.drive is None else resolve_drive(options.drive)
        drive = None
        if path is not None:
            drive = with_rate(load_drive(path), options.rate, f"{path} with --rate")
        if drive is None:
            trip = measure(options.rate or DEFAULT_RATE, together=options.in_process)
        else:
            trip = require_real_time(drive, str(path), together=options.in_process)
    except InputError as error:
        print(f"ecyl: {error}", file=sys.stderr)
        return 2
    print(f"{trip}: real time up to {trip.rate:g} Hz")
    return 0


def take_part(topic: str, role: str, rate: float) -> int:
    """One of the processes: `echo`, `ping` or `both`; the latter two print what they found."""
    import rclpy
    from rclpy.node import Node
    from rclpy.utilities import get_rmw_implementation_identifier

    from .direct_executor import make_executor
    from .scheduling import Awake, run_first

    rclpy.init(args=[])
    names = ("echo", "ping") if role == "both" else (role,)
    nodes = [Node(f"ecyl_{name}", start_parameter_services=False) for name in names]
    if role != "ping":
        _echo(nodes[0], topic)
    ping = _Ping(nodes[-1], topic, rate) if role != "echo" else None
    executor = make_executor(*nodes)
    run_first()
    if ping is None:
        executor.spin()
        return 0
    awake = Awake()
    executor.spin_until_future_complete(ping.done, PATIENCE_S)
    awake.end()
    took = sorted(ping.took)
    if len(took) < LEAST:
        return 1
    found = {"median_s": took[len(took) // 2], "p99_s": took[int(0.99 * len(took))]}
    print(json.dumps(found | {"middleware": get_rmw_implementation_identifier()}))
    rclpy.shutdown()
    return 0


if __name__ == "__main__":
    sys.exit(take_part(sys.argv[1], sys.argv[2], float(sys.argv[3])))
