"""What the transport alone can do: a message to another process and back, blocking in a wait set.

Ready CDR bytes of a two-joint JointState through `cyclonedds`, without rclpy, codec or executor on
either side. `outward=2` sends two messages for every one that comes back, as a control tick does.
"""

from __future__ import annotations

import argparse
import contextlib
import subprocess
import sys
import time
from collections.abc import Iterator
from typing import Any

from cyclonedds._clayer import ddspy_take, ddspy_write
from cyclonedds.core import InstanceState, Qos, ReadCondition, SampleState, ViewState, WaitSet
from cyclonedds.domain import Domain, DomainParticipant
from cyclonedds.idl import make_idl_struct, types
from cyclonedds.pub import DataWriter
from cyclonedds.qos import Policy
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration

LOOPBACK = (
    "<CycloneDDS><Domain Id='any'><General><Interfaces><NetworkInterface address='127.0.0.1'/>"
    "</Interfaces></General></Domain></CycloneDDS>"
)
ANY = SampleState.Any | ViewState.Any | InstanceState.Any
QUIET_S = 5  # the echo ends when nothing has come for so long


Stamp: Any = make_idl_struct(
    "Stamp", "builtin_interfaces::msg::dds_::Time_", {"sec": types.int32, "nanosec": types.uint32}
)
Header: Any = make_idl_struct(
    "Header", "std_msgs::msg::dds_::Header_", {"stamp": Stamp, "frame_id": str}
)
_numbers: Any = types.sequence[types.float64]  # type: ignore[misc]
JointState: Any = make_idl_struct(
    "JointState",
    "sensor_msgs::msg::dds_::JointState_",
    {
        "header": Header,
        "name": types.sequence[str],  # type: ignore[misc]
        "position": _numbers,
        "velocity": _numbers,
        "effort": _numbers,
    },
)


class End:
    """One end of the exchange: a writer, a reader, and a wait set on the reader."""

    def __init__(self, domain: int, writes: str, reads: str) -> None:
        self._domain = Domain(domain, LOOPBACK)
        participant = DomainParticipant(domain)
        qos = Qos(Policy.Reliability.Reliable(duration(seconds=1)), Policy.History.KeepLast(16))
        self._writer = DataWriter(participant, Topic(participant, writes, JointState), qos=qos)
        self._reader = DataReader(participant, Topic(participant, reads, JointState), qos=qos)
        self._waiting = WaitSet(participant)
        self._waiting.attach(ReadCondition(self._reader, ANY))
        self._participant = participant

    def send(self, data: bytes) -> None:
        """Write ready bytes."""
        ddspy_write(self._writer._ref, data)

    def receive(self, timeout_s: float) -> list[bytes]:
        """The messages that have come, waiting for one if there is none."""
        if not self._waiting.wait(duration(seconds=timeout_s)):
            return []
        taken = ddspy_take(self._reader._ref, ANY, 16)
        return [data for data, info in taken if info.valid_data]


def echo(domain: int, outward: int) -> None:
    """The other process: answer every `outward` messages with the last of them."""
    end = End(domain, "pong", "ping")
    waiting = 0
    while messages := end.receive(QUIET_S):
        waiting += len(messages)
        if waiting >= outward:
            waiting = 0
            end.send(messages[-1])


@contextlib.contextmanager
def _echo_process(domain: int, outward: int) -> Iterator[None]:
    command = [sys.executable, __file__, "--domain", str(domain), "--outward", str(outward)]
    process = subprocess.Popen(command)
    try:
        yield
    finally:
        process.terminate()
        process.wait()


def trips_per_s(seconds: float, domain: int, outward: int = 1) -> float:
    """Round trips a second between this process and an echo of its own."""
    header = Header(stamp=Stamp(sec=1, nanosec=2), frame_id="base")
    joints = JointState(
        header=header, name=["rotor", "rod"], position=[1.0, 2.0], velocity=[3.0, 4.0], effort=[]
    )
    data = joints.serialize()
    with _echo_process(domain, outward):
        end = End(domain, "ping", "pong")
        patience = time.monotonic() + 20.0
        while time.monotonic() < patience:  # until both directions are matched
            for _ in range(outward):
                end.send(data)
            if end.receive(0.1):
                break
        while end.receive(0.2):
            pass
        trips = 0
        begin = time.perf_counter()
        while (elapsed := time.perf_counter() - begin) < seconds:
            for _ in range(outward):
                end.send(data)
            if not end.receive(1.0):
                raise RuntimeError("a message did not come back")
            trips += 1
    return trips / elapsed


def main() -> None:
    """The echo process."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--domain", type=int, required=True)
    options.add_argument("--outward", type=int, default=1)
    chosen = options.parse_args()
    echo(chosen.domain, chosen.outward)


if __name__ == "__main__":
    main()
