"""Whether the bytes of a MAT file are what they say, before scipy's compiled reader gets them.

That reader trusts types and sizes: a damaged one ends the process or takes all memory. The format
is MathWorks' "MAT-File Format" (R2023b): level 5 from chapter 1, level 4 from chapter 2.
"""

from __future__ import annotations

import math
import struct
import zlib
from pathlib import Path

MI_INT8, MI_INT32, MI_UINT32, MI_MATRIX, MI_COMPRESSED, MI_UTF8 = 1, 5, 6, 14, 15, 16
# Type of data -> bytes of one entry.
NUMBERS = {1: 1, 2: 1, 3: 2, 4: 2, 5: 4, 6: 4, 7: 4, 9: 8, 12: 8, 13: 8}
LETTERS = {**NUMBERS, 16: 1, 17: 2, 18: 4}
CELL, STRUCT, OBJECT, CHAR, SPARSE, FUNCTION, OPAQUE = 1, 2, 3, 4, 5, 16, 17
NUMERIC = range(6, 16)
LOGICAL = 0x200
_DEEPEST = 30
_MOST_ELEMENTS = 200_000
_LARGEST = 2**31  # bytes of one variable unpacked


class MatError(ValueError):
    """What does not add up, and where."""


def check_mat(path: Path) -> None:
    """Walk all elements. Raises MatError for damage, OSError for a file that cannot be read."""
    data = path.read_bytes()
    mark = data[126:128]
    if len(data) >= 128 and mark in (b"IM", b"MI"):
        _Walk(data, "<" if mark == b"IM" else ">").file()
    else:
        _level_4(data)


class _Walk:
    """The elements of a level 5 file."""

    def __init__(self, data: bytes, order: str) -> None:
        self.data = data
        self.order = order
        self.elements = 0

    def file(self) -> None:
        """All variables."""
        if self.data[124:126] not in (b"\0\1", b"\1\0"):
            raise MatError("its version is none of 5 to 7")
        at = 128
        while at < len(self.data):
            kind, start, size, end = self._tag(self.data, at, len(self.data))
            if kind == MI_COMPRESSED:
                self._packed(self.data[start : start + size], at)
                end = start + size
            elif kind == MI_MATRIX:
                self._matrix(self.data, start, start + size, 0)
            else:
                raise MatError(f"the element at byte {at} is of type {kind}, expected a matrix")
            at = end

    def _packed(self, packed: bytes, at: int) -> None:
        try:
            unpacker = zlib.decompressobj()
            data = unpacker.decompress(packed, _LARGEST)
        except zlib.error:
            raise MatError(f"the variable at byte {at} does not decompress") from None
        if unpacker.unconsumed_tail or not unpacker.eof:
            raise MatError(f"the variable at byte {at} is cut off, or larger than {_LARGEST} bytes")
        kind, start, size, _ = self._tag(data, 0, len(data))
        if kind != MI_MATRIX:
            raise MatError(f"the variable at byte {at} is no matrix")
        self._matrix(data, start, start + size, 0)

    def _tag(self, data: bytes, at: int, end: int) -> tuple[int, int, int, int]:
        """Type, first byte, size of the element at a place, and where the next begins."""
        self.elements += 1
        if self.elements > _MOST_ELEMENTS:
            raise MatError(f"more than {_MOST_ELEMENTS} elements")
        if at + 8 > end:
            raise MatError(f"the element at byte {at} is cut off")
        (word,) = struct.unpack_from(f"{self.order}I", data, at)
        if word >> 16:  # up to four bytes stand within the tag
            size = word >> 16
            if size > 4:
                raise MatError(f"the small element at byte {at} has {size} bytes")
            return word & 0xFFFF, at + 4, size, at + 8
        (size,) = struct.unpack_from(f"{self.order}I", data, at + 4)
        if at + 8 + size > end:
            raise MatError(f"the element at byte {at} runs over its end")
        return word, at + 8, size, at + 8 + size + -size % 8

    def _matrix(self, data: bytes, at: int, end: int, depth: int) -> None:
        if at == end:  # an empty matrix may be left out
            return
        if depth > _DEEPEST:
            raise MatError(f"more than {_DEEPEST} matrices in each other")
        kind, start, size, at = self._tag(data, at, end)
        if kind != MI_UINT32 or size != 8:
            raise MatError(f"the matrix at byte {start - 8} has no flags")
        (flags,) = struct.unpack_from(f"{self.order}I", data, start)
        own, is_complex = flags & 0xFF, bool(flags & 0x800)
        if own == OPAQUE:
            self._rest(data, at, end, depth)
            return
        kind, start, size, at = self._tag(data, at, end)
        # Some writers call dimensions unsigned and names UTF-8; scipy takes these, too.
        if kind not in (MI_INT32, MI_UINT32) or size % 4 or not 8 <= size <= 128:
            raise MatError(f"the matrix at byte {start - 8} has no dimensions")
        dims = struct.unpack_from(f"{self.order}{size // 4}i", data, start)
        count = math.prod(dims)
        if min(dims) < 0 or count > _LARGEST:
            raise MatError(f"the matrix at byte {start - 8} has dimensions {dims[:4]}")
        kind, start, size, at = self._tag(data, at, end)
        if kind not in (MI_INT8, MI_UTF8):
            raise MatError(f"the matrix at byte {start - 8} has no name")
        if own in NUMERIC:
            for _ in range(2 if is_complex else 1):
                at = self._numbers(data, at, end, count)
        elif own == CHAR:
            kind, start, _, at = self._tag(data, at, end)
            if kind not in LETTERS:
                raise MatError(f"the letters at byte {start - 8} are of type {kind}")
        elif own == SPARSE:
            for _ in range(4 if is_complex else 3):
                kind, start, size, at = self._tag(data, at, end)
                # MATLAB 7 says of logical values that they are doubles, and writes bytes.
                if kind not in NUMBERS or (size % NUMBERS[kind] and not flags & LOGICAL):
                    raise MatError(f"the numbers at byte {start - 8} are of type {kind}")
        elif own in (STRUCT, OBJECT):
            self._structure(data, at, end, count, own == OBJECT, depth)
        elif own in (CELL, FUNCTION):
            for _ in range(count if own == CELL else 1):
                at = self._inner(data, at, end, depth)
        else:
            raise MatError(f"a matrix at byte {start - 8} is of class {own}")

    def _numbers(self, data: bytes, at: int, end: int, count: int) -> int:
        kind, start, size, at = self._tag(data, at, end)
        if kind not in NUMBERS or size != count * NUMBERS[kind]:
            raise MatError(f"the numbers at byte {start - 8}: {size} bytes of type {kind}")
        return at

    def _inner(self, data: bytes, at: int, end: int, depth: int) -> int:
        kind, start, size, at = self._tag(data, at, end)
        if kind != MI_MATRIX:
            raise MatError(f"the element at byte {start - 8} is of type {kind}, expected a matrix")
        self._matrix(data, start, start + size, depth + 1)
        return at

    def _structure(
        self, data: bytes, at: int, end: int, count: int, named: bool, depth: int
    ) -> None:
        if named:
            kind, start, _, at = self._tag(data, at, end)
            if kind != MI_INT8:
                raise MatError(f"the object at byte {start - 8} has no class name")
        kind, start, size, at = self._tag(data, at, end)
        if kind != MI_INT32 or size != 4:
            raise MatError(f"the structure at byte {start - 8} has no length of names")
        (length,) = struct.unpack_from(f"{self.order}i", data, start)
        kind, start, size, at = self._tag(data, at, end)
        if kind != MI_INT8 or length <= 0 or size % length:
            raise MatError(f"the structure at byte {start - 8} has no names of its fields")
        for _ in range(count * (size // length)):
            at = self._inner(data, at, end, depth)

    def _rest(self, data: bytes, at: int, end: int, depth: int) -> None:
        """Of an object of a newer class: strings, then a matrix."""
        while at < end:
            kind, start, size, at = self._tag(data, at, end)
            if kind == MI_MATRIX:
                self._matrix(data, start, start + size, depth + 1)
            elif kind not in LETTERS:
                raise MatError(f"the element at byte {start - 8} is of type {kind}")


def _level_4(data: bytes) -> None:
    """Variables of a level 4 file: a header of five numbers, a name, the numbers."""
    at = 0
    for order in "<>":
        if len(data) >= 20 and 0 <= struct.unpack_from(f"{order}i", data)[0] <= 5000:
            break
    else:
        raise MatError("it has neither the mark of version 5 nor the header of version 4")
    sizes = {0: 8, 1: 4, 2: 4, 3: 2, 4: 2, 5: 1}
    while at < len(data):
        if at + 20 > len(data):
            raise MatError(f"the variable at byte {at} is cut off")
        kind, rows, columns, imaginary, letters = struct.unpack_from(f"{order}5i", data, at)
        precision = kind // 10 % 10
        bad = not 0 <= kind <= 5000 or precision not in sizes or kind % 10 > 2
        if bad or min(rows, columns) < 0 or letters < 1 or imaginary not in (0, 1):
            raise MatError(f"the variable at byte {at} has no header of version 4")
        size = rows * columns * sizes[precision] * (2 if imaginary else 1)
        if at + 20 + letters + size > len(data):
            raise MatError(f"the variable at byte {at} runs over the end of the file")
        at += 20 + letters + size
