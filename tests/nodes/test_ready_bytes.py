"""Messages put together as bytes are what a serialiser makes of their fields."""

from __future__ import annotations

import numpy as np
import pytest
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Vector3, Vector3Stamped
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import JointState
from std_msgs.msg import Header

from ecyl_ros.nodes import ready_bytes
from ecyl_ros.nodes.ready_bytes import Incoming, Outgoing
from ecyl_ros.recording.cdr import CdrError, encode, layout_of, tidied
from ecyl_ros.recording.topics import JOINT_STATE


def _joints(names: tuple[str, ...], sec: int, start: float) -> JointState:
    numbers = [start + i for i in range(len(names))]
    header = Header(stamp=Time(sec=sec, nanosec=7), frame_id="base")
    return JointState(header=header, name=list(names), position=numbers, effort=numbers)


@pytest.mark.parametrize("names", [("rod",), ("rotor", "rod"), ("rotor", "rod", "a longer one")])
def test_packed_bytes_are_the_messages(names: tuple[str, ...]) -> None:
    """Whatever the joints' names do to the alignment, the bytes are those of rosbags."""
    paths = [f"{name}.{field}" for field in ("position", "effort") for name in names]
    outgoing = Outgoing(_joints(names, 1, 0.0), *paths)
    wanted = _joints(names, 12, 5.0)
    numbers = [*wanted.position, *wanted.effort]
    packed = outgoing.pack(12_000_000_007, numbers)
    fields = {path: np.array([number]) for path, number in zip(paths, numbers, strict=True)}
    (expected,) = encode(JOINT_STATE, "base", names, np.array([12_000_000_007]), fields)
    assert packed == expected
    by_middleware = bytes(serialize_message(wanted))
    assert packed == tidied(by_middleware, layout_of(JOINT_STATE, by_middleware))
    assert deserialize_message(packed, JointState) == wanted
    assert Incoming(JointState, *paths).unpack(packed) == (12_000_000_007, numbers)


def test_what_a_middleware_leaves_in_gaps_is_not_sent(monkeypatch: pytest.MonkeyPatch) -> None:
    """A serialiser that aligns with leftovers, before and behind, as Fast DDS does: same bytes."""
    message = _joints(("rod",), 1, 0.0)
    clean = Outgoing(message, "rod.position").pack(7, [2.5])
    gaps = layout_of(JOINT_STATE, clean).padding
    assert gaps

    def careless(message: JointState) -> bytes:
        data = bytearray(serialize_message(message))[: len(clean)]
        for begin, end in gaps:
            data[begin:end] = b"\xa5" * (end - begin)
        return bytes(data) + b"\xa5" * 5

    monkeypatch.setattr(ready_bytes, "serialize_message", careless)
    assert Outgoing(message, "rod.position").pack(7, [2.5]) == clean


def test_what_comes_in_may_change_its_layout_at_any_time() -> None:
    """Other frames, joints and orders between two messages are read right, and so is the next."""
    incoming = Incoming(JointState, "rod.position")
    for names in (("rod",), ("rotor", "rod"), ("rod", "rotor"), ("rod",)):
        message = _joints(names, 3, 1.5)
        expected = message.position[names.index("rod")]
        for _ in range(2):
            assert incoming.unpack(bytes(serialize_message(message)))[1] == [expected]
    voltage = Incoming(Vector3Stamped, "vector.x", "vector.y")
    for frame in ("dq0", "", "another frame"):
        header = Header(stamp=Time(sec=1), frame_id=frame)
        message = Vector3Stamped(header=header, vector=Vector3(x=2.0, y=-3.0, z=9.0))
        assert voltage.unpack(bytes(serialize_message(message))) == (10**9, [2.0, -3.0])


def test_messages_that_lack_a_number_are_named() -> None:
    """A missing joint, an empty array and bytes of another type raise with what was expected."""
    incoming = Incoming(JointState, "rod.velocity")
    with pytest.raises(CdrError, match=r"lacks rod\.velocity"):
        incoming.unpack(bytes(serialize_message(_joints(("rod",), 1, 0.0))))
    with pytest.raises(CdrError):
        incoming.unpack(b"\x00\x01\x00\x00" + bytes(7))
