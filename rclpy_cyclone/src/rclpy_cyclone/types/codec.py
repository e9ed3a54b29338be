"""CDR codec, generated per type.

rosbags generates one too, but for its own classes: it wants a numpy array in every numeric field,
where rclpy's messages hold ``array.array`` and lists. The tests compare the two byte for byte.

Alignment is known at generation time as far as possible: consecutive numbers become one
``struct`` call, and padding is computed at run time only behind strings and sequences. Lists of
strings, such as the names of joints, are mostly those of the message before: they are remembered.
"""

from __future__ import annotations

import array
import struct
import sys
from collections.abc import Callable
from typing import Any

import numpy

from rclpy_cyclone.types.classes import message_class
from rclpy_cyclone.types.store import SIZES, TYPECODES, Field, fields

HEADER = b"\x00\x01\x00\x00"
_CODES = {
    "bool": "?", "byte": "c", "char": "B", "int8": "b", "uint8": "B", "int16": "h",
    "uint16": "H", "int32": "i", "uint32": "I", "int64": "q", "uint64": "Q", "float32": "f",
    "float64": "d",
}  # fmt: skip
_MOST_REMEMBERED = 64  # strings in a list
_NATIVE = "<" if sys.byteorder == "little" else ">"


class _Writer:
    """Lines of a function, with the names its code refers to."""

    def __init__(self, order: str) -> None:
        self.lines: list[str] = []
        self.names: dict[str, Any] = {"array": array.array, "numpy": numpy, "len": len}
        self.order = order
        self.depth = 1
        self.known = 8  # the position is (0 modulo known) + offset
        self.offset = 0
        self.run: list[tuple[str, str]] = []  # (struct code, expression or target)
        self.temps = 0

    def emit(self, line: str) -> None:
        self.lines.append("    " * self.depth + line)

    def temp(self) -> str:
        self.temps += 1
        return f"t{self.temps}"

    def name(self, value: Any, stem: str) -> str:
        key = f"{stem}{len(self.names)}"
        self.names[key] = value
        return key

    def unknown(self) -> None:
        """Forget the position: something of variable length was passed."""
        self.known, self.offset = 1, 0

    def number(self, code: str, size: int, what: str) -> None:
        """Add a number to the current run, behind static or dynamic padding."""
        if self.known < size:
            self.flush()
            self.pad(size)
        gap = -self.offset % size
        if gap:
            self.run.append((f"{gap}x", ""))
        self.run.append((code, what))
        self.offset += gap + size

    def align(self, size: int) -> None:
        """Come to a multiple of ``size``, outside any run."""
        self.flush()
        if self.known < size:
            self.pad(size)
        elif gap := -self.offset % size:
            self.skip(gap)
            self.offset += gap

    def finish(self, head: str, tail: str | None = None) -> Callable[..., Any]:
        self.flush()
        if tail:
            self.emit(tail)
        code = "\n".join([head, *self.lines, "    pass"])
        space = dict(self.names)
        exec(code, space)
        return space["f"]

    def flush(self) -> None:
        raise NotImplementedError

    def pad(self, size: int) -> None:
        raise NotImplementedError

    def skip(self, gap: int) -> None:
        raise NotImplementedError


class _Serialiser(_Writer):
    """Appends to the bytearray ``o``, which starts with the four bytes of the header."""

    def flush(self) -> None:
        if not self.run:
            return
        packer = struct.Struct("<" + "".join(c for c, _ in self.run)).pack
        args = ", ".join(e for _, e in self.run if e)
        self.emit(f"o += {self.name(packer, 'p')}({args})")
        self.run = []

    def pad(self, size: int) -> None:
        self.emit(f"o += {self.name(_pads(size), 'z')}[len(o) & {size - 1}]")
        self.known, self.offset = size, 0

    def skip(self, gap: int) -> None:
        self.emit(f"o += {bytes(gap)!r}")

    def field(self, field: Field, expr: str) -> None:
        if field.kind == "one":
            self.one(field, expr)
            return
        values = self.temp()
        self.emit(f"{values} = {expr}")
        if field.kind == "sequence" and field.base == "string":
            self._strings(field, values)
            return
        if field.kind == "sequence":
            self.number("I", 4, f"len({values})")
            self.flush()
        elif field.nested or field.base not in TYPECODES:
            self.emit(f"if len({values}) != {field.length}: raise ValueError('array length')")
        if field.base in TYPECODES and not field.nested:
            size = SIZES[field.base]
            if field.kind == "array":
                self.align(size)
                self.emit(f"o += {values}.tobytes()")
                self.offset += size * field.length
                return
            self.emit(f"if {values}:")
            self.depth += 1
            known, offset = self.known, self.offset
            self.align(size)
            self.emit(f"o += {values}.tobytes()")
            self.depth -= 1
            # Whether there was padding depends on the length, so little is known from here.
            self.known, self.offset = (min(known, size), offset) if size <= 4 else (4, offset)
            return
        self.flush()
        item = self.temp()
        self.unknown()
        if field.nested:
            func = self.name(serialiser(field.base), "s")
            self.emit(f"for {item} in {values}: {func}(o, {item})")
        else:
            self.emit(f"for {item} in {values}:")
            self.depth += 1
            self.one(field, item)
            self.flush()
            self.depth -= 1
        self.unknown()

    def _strings(self, field: Field, values: str) -> None:
        self.align(4)
        last, begin, item = self.name([([], None)], "l"), self.temp(), self.temp()
        self.emit(f"k, {begin} = {last}[0]")
        self.emit(f"if {values} == k and {begin}: o += {begin}")
        self.emit("else:")
        self.depth += 1
        self.emit(f"{begin} = len(o)")
        self.unknown()
        self.known = 4
        self.number("I", 4, f"len({values})")
        self.flush()
        self.unknown()
        self.emit(f"for {item} in {values}:")
        self.depth += 1
        self.one(field, item)
        self.flush()
        self.depth -= 1
        self.emit(f"if len({values}) <= {_MOST_REMEMBERED}:")
        self.emit(f"    {last}[0] = list({values}), bytes(o[{begin}:])")
        self.depth -= 1
        self.unknown()

    def one(self, field: Field, expr: str) -> None:
        if field.nested:
            self.message(field.base, expr)
        elif field.base == "string":
            text = self.temp()
            self.emit(f"{text} = {expr}.encode()")
            self.number("I", 4, f"len({text}) + 1")
            self.flush()
            self.emit(f"o += {text}")
            self.emit("o += b'\\0'")
            self.unknown()
        else:
            self.number(_CODES[field.base], SIZES[field.base], expr)

    def message(self, typename: str, expr: str) -> None:
        members = fields(typename)
        if not members:
            self.number("B", 1, "0")
            return
        target = self.temp()
        self.emit(f"{target} = {expr}")
        for name, field in members:
            self.field(field, f"{target}._{name}")


def _pads(size: int) -> list[bytes]:
    # The header takes four bytes of the buffer, but alignment counts from behind it.
    return [bytes(-(n - 4) % size) for n in range(size)]


class _Deserialiser(_Writer):
    """Reads ``b`` (payload without the header) from position ``p``."""

    def flush(self) -> None:
        if not self.run:
            return
        form = struct.Struct(self.order + "".join(c for c, _ in self.run))
        targets = "".join(f"{t}, " for _, t in self.run if t)
        self.emit(f"{targets}= {self.name(form.unpack_from, 'u')}(b, p)")
        self.emit(f"p += {form.size}")
        self.run = []

    def pad(self, size: int) -> None:
        self.emit(f"p += -p & {size - 1}")
        self.known, self.offset = size, 0

    def skip(self, gap: int) -> None:
        self.emit(f"p += {gap}")

    def field(self, field: Field, target: str) -> None:
        if field.kind == "one":
            self.one(field, target)
            return
        count = str(field.length)
        if field.kind == "sequence" and field.base == "string":
            self._strings(field, target)
            return
        if field.kind == "sequence":
            count = self.temp()
            self.number("I", 4, count)
            self.flush()
        if field.base in TYPECODES and not field.nested:
            self._numbers(field, target, count)
            return
        self.flush()
        self.unknown()
        values = self.temp()
        self.emit(f"if {count} > len(b) - p: raise ValueError('sequence beyond the end')")
        self.emit(f"{values} = []")
        self.emit(f"for _ in range({count}):")
        self.depth += 1
        item = self.temp()
        if field.nested:
            func = self.name(deserialiser(field.base, self.order), "d")
            self.emit(f"{item}, p = {func}(b, p)")
        else:
            self.one(field, item)
            self.flush()
        self.emit(f"{values}.append({item})")
        self.depth -= 1
        self.emit(f"{target} = {values}")
        self.unknown()

    def _strings(self, field: Field, target: str) -> None:
        self.align(4)
        last, begin, count, item = self.name([(b"", [])], "l"), *(self.temp() for _ in range(3))
        # The same bytes at the same alignment: the same strings.
        self.emit(f"k, {count} = {last}[0]")
        self.emit(f"{begin} = p + len(k)")
        self.emit(f"if k and b[p:{begin}] == k: {target}, p = {count}[:], {begin}")
        self.emit("else:")
        self.depth += 1
        self.emit(f"{begin} = p")
        self.unknown()
        self.known = 4
        self.number("I", 4, count)
        self.flush()
        self.unknown()
        self.emit(f"if {count} > len(b) - p: raise ValueError('sequence beyond the end')")
        self.emit(f"{target} = k = []")
        self.emit(f"for _ in range({count}):")
        self.depth += 1
        self.one(field, item)
        self.flush()
        self.emit(f"k.append({item})")
        self.depth -= 1
        self.emit(f"if {count} <= {_MOST_REMEMBERED}: {last}[0] = bytes(b[{begin}:p]), k[:]")
        self.depth -= 1
        self.unknown()

    def _numbers(self, field: Field, target: str, count: str) -> None:
        size = SIZES[field.base]
        known, offset = self.known, self.offset
        if field.kind == "array":
            self.align(size)
            form = numpy.dtype(self.order + TYPECODES[field.base])
            data = self.name(form, "y")
            native = self.name(numpy.dtype(TYPECODES[field.base]), "n")
            self.emit(f"{target} = numpy.frombuffer(b, {data}, {count}, p).astype({native})")
            self.emit(f"p += {size * field.length}")
            self.offset += size * field.length
            return
        self.emit(f"if not {count}: {target} = array('{TYPECODES[field.base]}')")
        self.emit("else:")
        self.depth += 1
        self.align(size)
        end = self.temp()
        self.emit(f"{end} = p + {count} * {size}")
        self.emit(f"if {end} > len(b): raise ValueError('sequence beyond the end')")
        self.emit(f"{target} = array('{TYPECODES[field.base]}', b[p:{end}])")
        if self.order != _NATIVE:
            self.emit(f"{target}.byteswap()")
        self.emit(f"p = {end}")
        self.depth -= 1
        self.known, self.offset = (min(known, size), offset) if size <= 4 else (4, offset)

    def one(self, field: Field, target: str) -> None:
        if field.nested:
            self.message(field.base, target)
        elif field.base == "string":
            length = self.temp()
            self.number("I", 4, length)
            self.flush()
            self.emit(f"if {length} > len(b) - p: raise ValueError('string beyond the end')")
            self.emit(f"{target} = b[p:p + {length} - 1].decode() if {length} else ''")
            self.emit(f"p += {length}")
            self.unknown()
        else:
            self.number(_CODES[field.base], SIZES[field.base], target)

    def message(self, typename: str, target: str) -> None:

        cls = message_class(typename)
        made = self.temp()
        self.emit(f"{made} = {self.name(cls.__new__, 'c')}({self.name(cls, 'k')})")
        members = fields(typename)
        if not members:
            self.number("B", 1, self.temp())
        for name, field in members:
            self.field(field, f"{made}._{name}")
        self.emit(f"{target} = {made}")


_serialisers: dict[str, Callable[..., Any]] = {}
_deserialisers: dict[tuple[str, str], Callable[..., Any]] = {}


def serialiser(typename: str) -> Callable[[bytearray, Any], None]:
    """Return ``f(buffer, message)``, which appends the message to a buffer begun by a header."""
    if typename not in _serialisers:
        # A type may contain itself only through a sequence: let the cycle find this entry.
        _serialisers[typename] = lambda o, m: _serialisers[typename](o, m)
        writer = _Serialiser("<")
        writer.unknown()
        writer.message(typename, "m")
        _serialisers[typename] = writer.finish("def f(o, m):")
    return _serialisers[typename]


def deserialiser(typename: str, order: str = "<") -> Callable[[bytes, int], tuple[Any, int]]:
    """Return ``f(payload, position)``, which gives the message and the position behind it."""
    key = typename, order
    if key not in _deserialisers:
        _deserialisers[key] = lambda b, p: _deserialisers[key](b, p)
        writer = _Deserialiser(order)
        writer.unknown()
        writer.message(typename, "r")
        _deserialisers[key] = writer.finish("def f(b, p):", "return r, p")
    return _deserialisers[key]


def top_serialiser(typename: str) -> Callable[[Any], bytearray]:
    """Return ``f(message)``, which gives the whole CDR representation, header included."""
    writer = _Serialiser("<")
    writer.emit(f"o = bytearray({HEADER!r})")
    writer.message(typename, "m")
    return writer.finish("def f(m):", "return o")


def top_deserialiser(typename: str, order: str = "<") -> Callable[[bytes], Any]:
    """Return ``f(payload)``, which gives the message; the payload has no header."""
    writer = _Deserialiser(order)
    writer.emit("p = 0")
    writer.message(typename, "r")
    return writer.finish("def f(b):", "return r")
