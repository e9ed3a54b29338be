"""Where the numbers of a CDR message stand, from the type's definition: any field by its path."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .bag_contents import TopicMessages
from .cdr import NANOSECONDS, CdrError, CdrWalker

# Of a primitive: numpy's letters, size in bytes (OMG CDR 1; ROS interfaces, `char` is a uint8).
PRIMITIVES: dict[str, tuple[str, int]] = {
    "bool": ("u1", 1),
    "byte": ("u1", 1),
    "octet": ("u1", 1),
    "char": ("u1", 1),
    "int8": ("i1", 1),
    "uint8": ("u1", 1),
    "int16": ("i2", 2),
    "uint16": ("u2", 2),
    "int32": ("i4", 4),
    "uint32": ("u4", 4),
    "int64": ("i8", 8),
    "uint64": ("u8", 8),
    "float32": ("f4", 4),
    "float64": ("f8", 8),
}
_DEEPEST = 20  # of structures in structures
_MOST_PARTS = 20_000  # structures and strings of one message
_TOKEN = re.compile(r"([A-Za-z_][A-Za-z0-9_]*)|\.|\[([^\]\[]+)\]")


@dataclass(frozen=True)
class Run:
    """A primitive, or an array of them.

    Attributes:
        offset: of the first, from the message's first byte.
        letters, size: see `PRIMITIVES`.
        count: how many; None for a single one that is no array.
    """

    offset: int
    letters: str
    size: int
    count: int | None = None


@dataclass
class MessageLayout:
    """Where everything stands in messages of one structure.

    Attributes:
        big_endian: byte order.
        runs: path -> primitives.
        counts: path -> length of an array or sequence.
        names: path of an array of strings -> the strings.
        fixed: int64[m, 2], byte ranges that make the structure: lengths, and names.
        stamp: offset of the header's stamp (int32 sec, uint32 nanosec); None without one.
        template: the message that was walked.
    """

    big_endian: bool = False
    runs: dict[str, Run] = field(default_factory=dict)
    counts: dict[str, int] = field(default_factory=dict)
    names: dict[str, tuple[str, ...]] = field(default_factory=dict)
    fixed: NDArray[np.int64] = field(default_factory=lambda: np.zeros((0, 2), np.int64))
    stamp: int | None = None
    template: NDArray[np.uint8] = field(default_factory=lambda: np.zeros(0, np.uint8))

    def find(self, path: str, joint: str = "") -> Run:
        """The one primitive that a path means, as a `Run` without count.

        `a.b[2]` counts from 0; `a[name]`, or `a` with a joint, looks the name up among the
        message's own names: those beside `a`, or at its top.

        Raises:
            CdrError: nothing there; says what is.
        """
        run = self.runs.get(path)
        if run is not None and run.count is None:
            return run
        if run is not None:
            place = self._place(path, joint) if joint else 0
            if not joint and run.count != 1:
                raise CdrError(f"{path} holds {run.count} values, expected {path}[0] or a joint")
            return _element(run, place, path)
        head, index = self._actual(path, joint)
        run = self.runs.get(head)
        if run is None:
            known = ", ".join(list(self.runs)[:8])
            raise CdrError(f"no number at {path}; there are {known or 'none'}")
        if run.count is None:
            return run
        if index is None:
            return self.find(head, joint)
        return _element(run, index, head)

    def _actual(self, path: str, joint: str) -> tuple[str, int | None]:
        """The path with names turned into numbers, and the index at its end set apart."""
        made, index = "", None
        at = 0
        while at < len(path):
            token = _TOKEN.match(path, at)
            if token is None:
                raise CdrError(f"{path} is no path; expected such as position[0] or force.x")
            at = token.end()
            if token[1] is not None:
                made += ("." if made else "") + token[1]
                index = None
            elif token[2] is not None:
                if index is not None:
                    raise CdrError(f"{path} is no path; expected one index at a time")
                word = token[2].strip("\"' ")
                index = int(word) if word.isdecimal() else self._place(made, word)
            if index is not None and at < len(path):
                made += f"[{index}]"
                index = None
        return made, index

    def _place(self, path: str, name: str) -> int:
        """The index of a name in the list that goes with the array at `path`."""
        count = self.counts.get(path)
        if count is None:
            raise CdrError(f"{path} is no array")
        parent = path.rpartition(".")[0]
        found: list[str] = []
        for scope in dict.fromkeys((parent, "")):
            for place, names in self.names.items():
                if place.rpartition(".")[0] == scope and len(names) == count:
                    if name in names:
                        return names.index(name)
                    found += names
        known = ", ".join(found[:12])
        raise CdrError(f"no {name} among the names of {path}: {known or 'there are none'}")

    def listed(self, most: int) -> list[tuple[str, Run]]:
        """Up to `most` single primitives with their paths, of each array the first 64."""
        out: list[tuple[str, Run]] = []
        for path, run in self.runs.items():
            for i in range(min(1 if run.count is None else run.count, 64)):
                if len(out) >= most:
                    return out
                name = path if run.count is None else f"{path}[{i}]"
                out.append((name, _element(run, i, path)))
        return out


def _element(run: Run, index: int, path: str) -> Run:
    count = 1 if run.count is None else run.count
    if not 0 <= index < count:
        raise CdrError(f"{path} holds {count} values, expected an index below that, not {index}")
    return Run(run.offset + index * run.size, run.letters, run.size)


class MessageType:
    """A topic's type; walks its messages.

    Raises:
        CdrError: the definition is missing or does not parse.
    """

    def __init__(self, topic: TopicMessages) -> None:
        self.name = topic.type
        self._types = _definitions(topic)
        if self.name not in self._types:
            raise CdrError(f"no definition of {self.name[:80]}")

    def layout(self, data: bytes) -> MessageLayout:
        """Walk one message. Raises CdrError where the bytes do not fit the type."""
        walker = CdrWalker(data)
        layout = MessageLayout(big_endian=walker.order == ">")
        layout.template = np.frombuffer(data, dtype=np.uint8)
        layout.fixed = np.array([[0, 2]], dtype=np.int64)  # the byte order
        fixed: list[tuple[int, int]] = [(0, 2)]
        _Visit(self._types, walker, layout, fixed).structure(self.name, "", 0)
        walker.end()
        layout.fixed = np.array(fixed, dtype=np.int64).reshape(-1, 2)
        for path in ("header.stamp", "stamp"):
            if f"{path}.sec" in layout.runs and f"{path}.nanosec" in layout.runs:
                layout.stamp = layout.runs[f"{path}.sec"].offset
                del layout.runs[f"{path}.sec"], layout.runs[f"{path}.nanosec"]
                break
        return layout


class _Visit:
    """One walk through a message along its definition."""

    def __init__(
        self,
        types: Mapping[str, Any],
        walker: CdrWalker,
        layout: MessageLayout,
        fixed: list[tuple[int, int]],
    ) -> None:
        self.types = types
        self.walker = walker
        self.layout = layout
        self.fixed = fixed
        self.parts = 0

    def structure(self, name: str, path: str, depth: int) -> None:
        """All fields of a structure."""
        self.count_part()
        if depth > _DEEPEST:
            raise CdrError(f"more than {_DEEPEST} structures in each other")
        if name not in self.types:
            raise CdrError(f"no definition of {name[:80]}")
        for field_name, kind in self.types[name][1]:
            self.member(kind, f"{path}.{field_name}" if path else field_name, depth)

    def count_part(self) -> None:
        """Keep a damaged length from making the walk endless."""
        self.parts += 1
        if self.parts > _MOST_PARTS:
            raise CdrError(f"more than {_MOST_PARTS} parts in one message")

    def member(self, kind: Any, path: str, depth: int) -> None:
        """One field: a primitive, a string, a structure, or several of these."""
        node, detail = int(kind[0]), kind[1]
        if node == 1:
            if detail[0] in ("string", "wstring"):
                self.string(detail[0], content=False)
            else:
                self.primitives(detail[0], path, None)
        elif node == 2:
            self.structure(detail, path, depth + 1)
        else:
            count = detail[1] if node == 3 else self.length()
            self.several(detail[0], path, count, depth)

    def length(self) -> int:
        """Of a sequence, which is part of the structure."""
        value = self.walker.uint32()
        self.fixed.append((self.walker.at - 4, self.walker.at))
        if value > len(self.walker.data):
            raise CdrError(f"claims {value} entries in {len(self.walker.data)} bytes")
        return value

    def several(self, kind: Any, path: str, count: int, depth: int) -> None:
        """An array or sequence."""
        self.layout.counts[path] = count
        node, detail = int(kind[0]), kind[1]
        if node == 1 and detail[0] not in ("string", "wstring"):
            self.primitives(detail[0], path, count)
        elif node == 1:
            content = detail[0] == "string"
            names = tuple(self.string(detail[0], content=content) for _ in range(count))
            if content:
                self.layout.names[path] = names
        else:
            for i in range(count):
                self.member(kind, f"{path}[{i}]", depth + 1)

    def string(self, kind: str, *, content: bool) -> str:
        """A string; with `content` its letters are part of the structure, not just its length."""
        self.count_part()
        size = self.length()
        if kind == "wstring":
            self.walker.take(1, 2 * size)
            return ""
        start = self.walker.take(1, size)
        if not content:
            return ""
        self.fixed.append((start, start + size))
        raw = bytes(self.walker.data[start : start + size])
        return raw.rstrip(b"\0").decode("utf-8", "replace")

    def primitives(self, name: str, path: str, count: int | None) -> None:
        """One, or an array of them."""
        if name not in PRIMITIVES:
            raise CdrError(f"no such primitive: {name[:40]}")
        letters, size = PRIMITIVES[name]
        start = self.walker.take(size, 1 if count is None else count)
        self.layout.runs[path] = Run(start, letters, size, count)


def _definitions(topic: TopicMessages) -> Mapping[str, Any]:
    """Fields by type name, from the bag's own definition, else from what ROS ships."""
    from .messages import typestore

    if not topic.definition:
        shipped: Mapping[str, Any] = typestore().fielddefs
        return shipped
    from rosbags.typesys import get_types_from_idl, get_types_from_msg

    try:
        if topic.definition_encoding == "ros2idl":
            own = get_types_from_idl(_plain_idl(topic.definition))
        elif topic.definition_encoding == "ros2msg":
            own = get_types_from_msg(topic.definition, topic.type)
        else:
            raise CdrError(f"definition is {topic.definition_encoding[:40]!r}, expected ros2msg")
    except CdrError:
        raise
    # The parsers of rosbags raise whatever a broken text leads them to.
    except Exception as error:
        reason = " ".join(str(error).split())[:120]
        raise CdrError(f"definition of {topic.type[:80]} does not parse: {reason}") from None
    return {**typestore().fielddefs, **own}


def _plain_idl(text: str) -> str:
    """Without the `====` and `IDL: name` lines by which several files are strung together."""
    lines = [line for line in text.splitlines() if not re.match(r"^(=+|IDL:.*)$", line.strip())]
    return "\n".join(lines)


def stamp_ns(table: NDArray[np.uint8], big_endian: bool) -> NDArray[np.int64]:
    """int64[n] from the 8 bytes of each stamp, uint8[n, 8]; -1 where its nanoseconds are none."""
    order = ">" if big_endian else "<"
    whole = np.ascontiguousarray(table)
    sec = whole[:, :4].copy().view(f"{order}i4")[:, 0].astype(np.int64)
    nanosec = whole[:, 4:].copy().view(f"{order}u4")[:, 0].astype(np.int64)
    out = sec * NANOSECONDS + nanosec
    out[nanosec >= NANOSECONDS] = -1
    return out
