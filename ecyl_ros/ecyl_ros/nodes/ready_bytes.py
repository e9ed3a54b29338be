"""Messages of one layout as CDR bytes: numbers are put in place and read there.

To turn a message with joint names into bytes and back costs rclpy more than to send it, at every
tick, twice. rclpy publishes bytes as they are and hands bytes over to subscriptions made with
`raw=True`; on the wire they are ordinary messages. Nothing is taken for granted of what comes in:
as soon as a byte differs that is neither stamp nor number, the message is walked again.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from typing import Any

from geometry_msgs.msg import Vector3Stamped
from rclpy.serialization import serialize_message
from sensor_msgs.msg import JointState

from ..recording.cdr import CdrError, Layout, layout_of, tidied
from ..recording.topics import JOINT_STATE, VECTOR3_STAMPED
from .wire import NANOSECONDS

_NAMES = {JointState: JOINT_STATE, Vector3Stamped: VECTOR3_STAMPED}
_NUMBER = 8  # bytes of a float64


def _fixed(layout: Layout, size: int) -> list[slice]:
    """The bytes that are neither stamp nor number nor padding."""
    parts, end = [], 0
    for start, stop in layout.changing:
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
        data = tidied(data, layout)  # every middleware sends, and a recorder writes, the same
        places = [layout.values[path] for path in paths]
        # One struct of the whole message: stamp, constant bytes and numbers by turns.
        changing = sorted([(layout.stamp, "iI", 8), *((at, "d", _NUMBER) for at in places)])
        form, end = layout.order, 0
        self._fields: list[Any] = []
        slots: list[int] = []
        for at, code, size in changing:
            if at > end:
                form += f"{at - end}s"
                self._fields.append(data[end:at])
            slots.append(len(self._fields))
            self._fields += [0] * len(code)
            form, end = form + code, at + size
        self._struct = struct.Struct(f"{form}{len(data) - end}s")
        self._fields.append(data[end:])
        self._stamp = slots.pop(0)  # it stands in the header, before all numbers
        order = sorted(range(len(places)), key=places.__getitem__)
        self._slots = tuple(zip(slots, order, strict=True))

    def pack(self, stamp_ns: int, numbers: Sequence[float]) -> bytes:
        """The message with this stamp, ns, and these numbers in the order of the paths."""
        fields, at = self._fields, self._stamp
        fields[at], fields[at + 1] = divmod(stamp_ns, NANOSECONDS)
        for slot, index in self._slots:
            fields[slot] = numbers[index]
        return self._struct.pack(*fields)


class Incoming:
    """Reads the stamp and some numbers of messages whose layout seldom changes."""

    def __init__(self, kind: Any, *paths: str) -> None:
        """kind: JointState or Vector3Stamped. paths: the numbers wanted (see `TopicSpec`)."""
        self._name = _NAMES[kind]
        self._paths = paths
        self._size = -1
        self._known: list[tuple[slice, bytes]] = []
        self._struct = struct.Struct("<")
        self._order: tuple[int, ...] = ()

    def unpack(self, data: bytes) -> tuple[int, list[float]]:
        """Stamp in ns and numbers in the order of the paths.

        Raises CdrError, with the reason, for bytes that are no such message or lack a number.
        """
        if len(data) != self._size:
            self._learn(bytes(data))
        for part, kept in self._known:
            if data[part] != kept:
                self._learn(bytes(data))
                break
        found = self._struct.unpack_from(data)
        return found[0] * NANOSECONDS + found[1], [found[index] for index in self._order]

    def _learn(self, data: bytes) -> None:
        self._size = -1  # unless all goes well
        layout = layout_of(self._name, data)
        missing = [path for path in self._paths if path not in layout.values]
        if missing:
            raise CdrError(f"{self._name} lacks {missing[0]}")
        places = [layout.values[path] for path in self._paths]
        form, end = f"{layout.order}{layout.stamp}xiI", layout.stamp + 8
        for at in sorted(places):
            form, end = f"{form}{at - end}xd", at + _NUMBER
        self._struct = struct.Struct(form)
        ranks = sorted(places)
        self._order = tuple(2 + ranks.index(at) for at in places)
        self._known = [(part, data[part]) for part in _fixed(layout, len(data))]
        self._size = len(data)
