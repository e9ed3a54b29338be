"""Messages of one layout as CDR bytes: numbers are put in place and read there.

To turn a message with joint names into bytes and back costs rclpy more than to send it, at every
tick, twice. rclpy publishes bytes as they are and hands bytes over to subscriptions made with
`raw=True`; on the wire they are ordinary messages. Nothing is taken for granted of what comes in:
as soon as a byte differs that is neither stamp nor number, the message is walked anew.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from typing import Any

from geometry_msgs.msg import Vector3Stamped
from rclpy.serialization import serialize_message
from sensor_msgs.msg import JointState

from ..recording.cdr import HEADER, CdrError, Layout, layout_of
from ..recording.topics import JOINT_STATE, VECTOR3_STAMPED
from .wire import NANOSECONDS

_NAMES = {JointState: JOINT_STATE, Vector3Stamped: VECTOR3_STAMPED}
_NUMBER = 8  # bytes of a float64


def _runs(offsets: Sequence[int], order: str) -> list[tuple[struct.Struct, int, slice]]:
    """Neighbours among the numbers, to be packed at once: their struct, offset and places."""
    runs: list[tuple[struct.Struct, int, slice]] = []
    start = 0
    for i in range(1, len(offsets) + 1):
        if i == len(offsets) or offsets[i] != offsets[i - 1] + _NUMBER:
            packed = struct.Struct(f"{order}{i - start}d")
            runs.append((packed, offsets[start], slice(start, i)))
            start = i
    return runs


def _fixed(layout: Layout, size: int) -> list[slice]:
    """The bytes that are neither stamp nor number."""
    changing = [(layout.stamp, layout.stamp + 8)]
    changing += [(at, at + _NUMBER) for at in layout.values.values()]
    parts, end = [], 0
    for start, stop in sorted(changing):
        if start > end:
            parts.append(slice(end, start))
        end = stop
    return [*parts, slice(end, size)] if size > end else parts


class Outgoing:
    """Writes one message over and over with other stamps and numbers."""

    def __init__(self, message: JointState | Vector3Stamped, *paths: str) -> None:
        """message: what stays as it is. paths: the numbers to be written (see `TopicSpec`)."""
        data = bytes(serialize_message(message))
        layout = layout_of(_NAMES[type(message)], data)
        self._data = bytearray(data)
        self._stamp = struct.Struct(f"{layout.order}iI")
        self._at = layout.stamp
        self._runs = _runs([layout.values[path] for path in paths], layout.order)

    def pack(self, stamp_ns: int, numbers: Sequence[float]) -> bytes:
        """The message with this stamp, ns, and these numbers in the order of the paths."""
        data = self._data
        self._stamp.pack_into(data, self._at, *divmod(stamp_ns, NANOSECONDS))
        for packed, offset, places in self._runs:
            packed.pack_into(data, offset, *numbers[places])
        return bytes(data)


class Incoming:
    """Reads the stamp and some numbers of messages whose layout seldom changes."""

    def __init__(self, kind: Any, *paths: str) -> None:
        """kind: JointState or Vector3Stamped. paths: the numbers wanted (see `TopicSpec`)."""
        self._name = _NAMES[kind]
        self._paths = paths
        self._size = -1
        self._known: list[tuple[slice, bytes]] = []
        self._stamp, self._at = struct.Struct("<iI"), HEADER
        self._runs: list[tuple[struct.Struct, int, slice]] = []

    def unpack(self, data: bytes) -> tuple[int, list[float]]:
        """Stamp in ns and numbers in the order of the paths.

        Raises CdrError, with the reason, for bytes that are no such message or lack a number.
        """
        if len(data) != self._size or any(data[part] != kept for part, kept in self._known):
            self._learn(bytes(data))
        sec, nanosec = self._stamp.unpack_from(data, self._at)
        numbers: list[float] = []
        for packed, offset, _ in self._runs:
            numbers += packed.unpack_from(data, offset)
        return sec * NANOSECONDS + nanosec, numbers

    def _learn(self, data: bytes) -> None:
        self._size = -1  # unless all goes well
        layout = layout_of(self._name, data)
        missing = [path for path in self._paths if path not in layout.values]
        if missing:
            raise CdrError(f"{self._name} lacks {missing[0]}")
        self._stamp, self._at = struct.Struct(f"{layout.order}iI"), layout.stamp
        self._runs = _runs([layout.values[path] for path in self._paths], layout.order)
        self._known = [(part, data[part]) for part in _fixed(layout, len(data))]
        self._size = len(data)
