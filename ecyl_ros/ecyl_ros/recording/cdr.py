"""Many CDR messages of one layout at once: JointState and Vector3Stamped to arrays and back.

Decoding 48 000 messages one by one takes half a second. But within one topic all bytes stay the
same except the stamp and the float64 values. So one message is walked to find where these stand,
the other bytes are compared, and the values are read as columns. Messages that differ elsewhere
(another joint name, more joints) start a layout of their own: no assumption, only speed.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray, StampArray
from .messages import typestore
from .topics import JOINT_FIELDS, JOINT_STATE, VECTOR3_STAMPED, VECTOR_FIELDS

# Alignment counts from behind the encapsulation header (CDR 1, OMG DDSI-RTPS 10.2).
HEADER = 4
NANOSECONDS = 1_000_000_000
# A topic has one layout, a few when joints come or go. Hundreds mean damaged or foreign bytes.
MAX_LAYOUTS = 100
# Bytes behind a message. Some middlewares (Fast DDS) send as much as they reckoned beforehand:
# aligned to 8 at the end, and before the numbers of each array, though it holds none.
MOST_PADDING = 7 + 3 * 8


class CdrError(ValueError):
    """Bytes that are no CDR message of the expected type; says what was expected where."""


@dataclass(frozen=True)
class Layout:
    """Where the changing parts of a message stand in its bytes.

    Attributes:
        order: struct's byte order character, `<` or `>`.
        stamp: offset of header.stamp (int32 sec, uint32 nanosec).
        values: field path (see `TopicSpec.signals`) -> offset of its float64.
        joints: names of a JointState, in order.
        padding: begin and end of bytes that align what follows, or stand behind the message; what
            they hold is left to chance.
    """

    order: str
    stamp: int
    values: Mapping[str, int]
    joints: tuple[str, ...]
    padding: tuple[tuple[int, int], ...]

    @property
    def changing(self) -> list[tuple[int, int]]:
        """Begin and end of what may differ between two messages of this layout, in order."""
        stamp = (self.stamp, self.stamp + 8)
        values = [(at, at + 8) for at in self.values.values()]
        return sorted([stamp, *values, *self.padding])


class CdrWalker:
    """Reads primitives at increasing offsets, aligned as CDR has it."""

    def __init__(self, data: bytes) -> None:
        if len(data) < HEADER or data[0] != 0 or data[1] not in (0, 1):
            raise CdrError(f"expected a CDR header 0000 or 0001, found {data[:2].hex() or 'none'}")
        self.data = data
        self.order = "<" if data[1] else ">"
        self.at = HEADER
        self.gaps: list[tuple[int, int]] = []

    def take(self, size: int, count: int = 1) -> int:
        """Offset of `count` values of `size` bytes; moves behind them."""
        gap = -(self.at - HEADER) % size if count else 0
        if gap:
            self.gaps.append((self.at, self.at + gap))
        start = self.at = self.at + gap
        self.at += size * count
        if self.at > len(self.data):
            raise CdrError(f"needs {self.at} bytes or more, has {len(self.data)}")
        return start

    def uint32(self) -> int:
        return int(struct.unpack_from(f"{self.order}I", self.data, self.take(4))[0])

    def string(self) -> str:
        length = self.uint32()
        start = self.take(1, length)
        try:
            return self.data[start : start + length].rstrip(b"\0").decode()
        except UnicodeDecodeError:
            raise CdrError(f"expected text at byte {start}") from None

    def end(self) -> None:
        # More than padding belongs to another type.
        if len(self.data) - self.at > MOST_PADDING:
            raise CdrError(f"ends at byte {self.at}, has {len(self.data)}")
        if len(self.data) > self.at:
            self.gaps.append((self.at, len(self.data)))


def layout_of(message_type: str, data: bytes) -> Layout:
    """Walk one message. Raises CdrError where the bytes do not fit the type."""
    walker = CdrWalker(data)
    stamp = walker.take(4, 2)
    walker.string()  # frame_id
    values: dict[str, int] = {}
    joints: tuple[str, ...] = ()
    if message_type == VECTOR3_STAMPED:
        start = walker.take(8, 3)
        values = {f"vector.{name}": start + 8 * i for i, name in enumerate(VECTOR_FIELDS)}
    elif message_type == JOINT_STATE:
        count = walker.uint32()
        if count > len(data):
            raise CdrError(f"claims {count} joint names in {len(data)} bytes")
        joints = tuple(walker.string() for _ in range(count))
        if len(set(joints)) != count:
            raise CdrError(f"names a joint twice: {', '.join(joints)}")
        for name in JOINT_FIELDS:
            entries = walker.uint32()
            if entries not in (0, count):
                raise CdrError(f"has {entries} values of {name} for {count} joints")
            start = walker.take(8, entries)
            for i in range(entries):
                values[f"{joints[i]}.{name}"] = start + 8 * i
    else:
        raise CdrError(f"no layout known for {message_type}")
    walker.end()
    return Layout(walker.order, stamp, values, joints, tuple(walker.gaps))


def tidied(data: bytes, layout: Layout) -> bytes:
    """The same message with zeros where bytes only align, and without those behind it.

    So most middlewares serialise it; Fast DDS leaves both to chance.
    """
    clean = bytearray(data)
    for begin, end in layout.padding:
        clean[begin:end] = bytes(end - begin)
    if layout.padding and layout.padding[-1][1] == len(data):
        del clean[layout.padding[-1][0] :]
    return bytes(clean)


def decode(
    message_type: str, messages: Sequence[bytes], paths: Sequence[str]
) -> tuple[StampArray, dict[str, FloatArray], set[str]]:
    """Stamps and values of many messages.

    Args:
        message_type: JointState or Vector3Stamped.
        messages: n CDR messages.
        paths: field paths wanted (see `TopicSpec.signals`).

    Returns:
        header stamps in ns, int64[n]; float64[n] per path, NaN where a message has no such
        field; all joint names met.

    Raises:
        CdrError: a message that is not of this type, or a stamp whose nanoseconds are no fraction
            of a second. Its text starts with the message's index.
    """
    count = len(messages)
    stamps = np.empty(count, dtype=np.int64)
    values = {path: np.full(count, np.nan) for path in paths}
    joints: set[str] = set()
    layouts = 0
    lengths = np.fromiter(map(len, messages), dtype=np.int64, count=count)
    for length in np.unique(lengths):
        rows = np.flatnonzero(lengths == length)
        joined = b"".join([messages[row] for row in rows.tolist()])
        table = np.frombuffer(joined, dtype=np.uint8).reshape(rows.size, length)
        while rows.size:
            try:
                layout = layout_of(message_type, table[0].tobytes())
            except CdrError as error:
                raise CdrError(f"message {rows[0]}: {error}") from None
            layouts += 1
            if layouts > MAX_LAYOUTS:
                raise CdrError(f"message {rows[0]}: more than {MAX_LAYOUTS} layouts in one topic")
            joints.update(layout.joints)
            fixed = np.ones(length, dtype=bool)
            for begin, end in layout.changing:
                fixed[begin:end] = False
            alike = (table[:, fixed] == table[0, fixed]).all(axis=1)
            matching, chosen = table[alike], rows[alike]
            sec = _column(matching, layout.stamp, f"{layout.order}i4")
            nanosec = _column(matching, layout.stamp + 4, f"{layout.order}u4")
            if (nanosec >= NANOSECONDS).any():
                row = chosen[nanosec >= NANOSECONDS][0]
                raise CdrError(f"message {row}: stamp with nanosec of a second or more")
            stamps[chosen] = sec.astype(np.int64) * NANOSECONDS + nanosec
            for path in paths:
                if path in layout.values:
                    column = _column(matching, layout.values[path], f"{layout.order}f8")
                    values[path][chosen] = column
            table, rows = table[~alike], rows[~alike]
    return stamps, values, joints


def encode(
    message_type: str,
    frame_id: str,
    joints: Sequence[str],
    stamp_ns: StampArray,
    values: Mapping[str, FloatArray],
) -> list[bytes]:
    """Many messages from arrays, byte for byte as rosbags (and rclpy) serialise them.

    Args:
        message_type: JointState or Vector3Stamped.
        frame_id: of the header.
        joints: names of a JointState; empty for a vector.
        stamp_ns: int64[n], not negative.
        values: float64[n] per field path. See `TopicSpec.signals` for what the others become.
    """
    template = _template(message_type, frame_id, joints, values)
    layout = layout_of(message_type, template)
    size = len(template)
    table = np.tile(np.frombuffer(template, dtype=np.uint8), (stamp_ns.size, 1))
    _put(table, layout.stamp, (stamp_ns // NANOSECONDS).astype("<i4"))
    _put(table, layout.stamp + 4, (stamp_ns % NANOSECONDS).astype("<u4"))
    for path, column in values.items():
        _put(table, layout.values[path], np.asarray(column, dtype="<f8"))
    data = table.tobytes()
    return [data[i * size : (i + 1) * size] for i in range(stamp_ns.size)]


def _template(
    message_type: str, frame_id: str, joints: Sequence[str], paths: Mapping[str, FloatArray]
) -> bytes:
    types = typestore().types
    header = types["std_msgs/msg/Header"](
        stamp=types["builtin_interfaces/msg/Time"](sec=0, nanosec=0), frame_id=frame_id
    )
    if message_type == VECTOR3_STAMPED:
        vector = types["geometry_msgs/msg/Vector3"](x=0.0, y=0.0, z=0.0)
        message = types[VECTOR3_STAMPED](header=header, vector=vector)
    else:
        used = {path.rpartition(".")[2] for path in paths}
        arrays = {
            name: np.full(len(joints) if name in used else 0, np.nan) for name in JOINT_FIELDS
        }
        message = types[JOINT_STATE](header=header, name=list(joints), **arrays)
    return bytes(typestore().serialize_cdr(message, message_type))


def _column(table: NDArray[np.uint8], offset: int, dtype: str) -> NDArray:
    size = np.dtype(dtype).itemsize
    return np.ascontiguousarray(table[:, offset : offset + size]).view(dtype)[:, 0]


def _put(table: NDArray[np.uint8], offset: int, column: NDArray) -> None:
    size = column.dtype.itemsize
    table[:, offset : offset + size] = np.ascontiguousarray(column).view(np.uint8).reshape(-1, size)
