"""The records of one MCAP file, also when it was cut off.

The `mcap` package parses the records. Their framing is walked here, because its stream reader
hands out what is left of a record at the end of a cut file as if it were whole. One record is
held at a time.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable, Collection, Generator, Iterator
from io import BytesIO
from pathlib import Path
from typing import Any, BinaryIO

from ..errors import InputError
from . import unclosed
from .bag_contents import Bag, TopicMessages
from .packed import plain_message

MAGIC = b"\x89MCAP0\r\n"
RECORD = struct.Struct("<BQ")  # opcode, length of what follows
MESSAGE = struct.Struct("<HIQQ")  # channel, sequence, log time, publish time
CHUNK = struct.Struct("<QQQI")  # first and last log time, uncompressed size, its CRC-32
FOOTER = struct.Struct("<BQQQI")  # opcode, length, starts of summary and of its index, CRC-32
# Larger than any recorder's chunks (rosbag2: 0.8 MB): a record that claims more is damaged, and
# unpacking it could take all memory.
LARGEST_CHUNK = 2**29

OP_FOOTER, OP_SCHEMA, OP_CHANNEL, OP_MESSAGE, OP_CHUNK, OP_STATISTICS = 2, 3, 4, 5, 6, 11
READ = (OP_FOOTER, OP_SCHEMA, OP_CHANNEL, OP_MESSAGE, OP_CHUNK, OP_STATISTICS)


class CorruptError(ValueError):
    """Bytes that no writer leaves behind, not even one that was cut off."""


class FileReader:
    """Walks one MCAP file's records into a bag.

    Args:
        file: the file.
        bag: where its topics, and in this class their messages too, are put.
        topics: names of those wanted; all by default.
        counter: messages before this file.
    """

    def __init__(
        self, file: Path, bag: Bag, topics: Collection[str] | None = None, counter: int = 0
    ) -> None:
        self.file = file
        self.bag = bag
        self.wanted = topics
        self.counter = counter
        self.first = counter
        self.schemas: dict[int, tuple[str, str, str]] = {}
        self.channels: dict[int, tuple[TopicMessages, bool]] = {}
        self.finished = False
        self.at = 0  # bytes of the file gone through

    def steps(self) -> Iterator[None]:
        """Read; yields after each record, so that what it held can be taken out.

        Raises:
            InputError: as `read_bag`.
        """
        try:
            with self.file.open("rb") as stream:
                yield from self._read(stream, self.file.stat().st_size)
        except OSError as error:
            raise InputError(f"{self.file}: cannot be read: {error.strerror}") from None
        except CorruptError as error:
            raise InputError(f"{self.file}: damaged: {error}") from None

    def _read(self, stream: BinaryIO, size: int) -> Iterator[None]:
        if not size:
            raise InputError(f"{self.file}: is empty, expected an MCAP file")
        start = stream.read(len(MAGIC))
        if start != MAGIC:
            raise InputError(f"{self.file}: is no MCAP file (it starts with {start.hex()})")
        stream.seek(max(size - len(MAGIC), 0))
        # A file that bears the end mark was finished: whatever does not add up in it is damage.
        # Without it the writer was stopped, and may have left anything behind its last flush.
        if size >= 2 * len(MAGIC) and stream.read() == MAGIC:
            at = yield from self._walk(stream, size - len(MAGIC))
            if not self.finished:
                raise CorruptError(f"the record at byte {at} runs over the end of the file")
            if unclosed.is_at_end(stream, size):
                kept = self.counter - self.first
                self.bag.notes += (f"{self.file}: was not closed: {kept} whole messages kept",)
            return
        try:
            at = yield from self._walk(stream, size)
            stream.seek(at)
            header = stream.read(RECORD.size)
            if len(header) == RECORD.size and header[0] == OP_CHUNK:
                self._cut_chunk(memoryview(stream.read(LARGEST_CHUNK)))
            why = ""
        except CorruptError as error:
            why = f" ({error})"
        self.bag.notes += (
            f"{self.file}: was cut off before its end, at byte {size}: "
            f"{self.counter - self.first} whole messages kept{why}",
        )
        yield

    def _walk(self, stream: BinaryIO, end: int) -> Generator[None, None, int]:
        """Take in the whole records before `end` or the footer; returns where the last one ends."""
        at = len(MAGIC)
        while at + RECORD.size <= end and not self.finished:
            stream.seek(at)
            opcode, length = RECORD.unpack(stream.read(RECORD.size))
            start = at + RECORD.size
            if start + length > end:
                break
            # Indexes are not needed, and an attachment may be larger than memory.
            if opcode in READ and self._needed(opcode, stream, length):
                if length > 2 * LARGEST_CHUNK:
                    raise CorruptError(f"the record at byte {at} has {length} bytes")
                self._record(opcode, memoryview(stream.read(length)), at)
                self.at = start + length
                yield
            at = start + length
        return at

    def _needed(self, opcode: int, stream: BinaryIO, length: int) -> bool:
        """Whether to read the record that begins where the stream stands; leaves it there."""
        return True

    def _record(self, opcode: int, body: memoryview, at: int) -> None:
        if opcode == OP_CHUNK:
            self._chunk(body, at)
        elif opcode == OP_MESSAGE:
            self._message(body, at)
        elif opcode == OP_SCHEMA:
            schema = parsed("Schema", body, at)
            text = schema.data.decode("utf-8", "replace")
            self.schemas[schema.id] = (schema.name, text, schema.encoding)
        elif opcode == OP_CHANNEL:
            self._channel(parsed("Channel", body, at), at)
        elif opcode == OP_STATISTICS:
            self._check_count(parsed("Statistics", body, at).message_count)
        elif opcode == OP_FOOTER:
            self.finished = True

    def _check_count(self, counted: int) -> None:
        held = self.counter - self.first
        if counted != held:
            raise CorruptError(f"holds {held} messages where its statistics count {counted}")

    def _channel(self, channel: Any, at: int) -> None:
        if channel.schema_id not in self.schemas:
            raise CorruptError(f"topic {channel.topic!r} at byte {at} has no schema")
        name, definition, encoding = self.schemas[channel.schema_id]
        topic = self.bag.topics.get(channel.topic)
        if topic is None:
            topic = self.bag.topics[channel.topic] = TopicMessages(
                name=channel.topic,
                type=name,
                encoding=channel.message_encoding,
                qos=channel.metadata.get("offered_qos_profiles", ""),
                definition=definition,
                definition_encoding=encoding,
            )
        elif (topic.type, topic.encoding) != (name, channel.message_encoding):
            raise InputError(
                f"{self.file}: {channel.topic} is {topic.type} in one place and {name} in another"
            )
        self.channels[channel.id] = (
            topic,
            self.wanted is None or channel.topic in self.wanted,
        )

    def _message(self, body: memoryview, at: int) -> None:
        if len(body) < MESSAGE.size:
            raise CorruptError(f"the message at byte {at} is shorter than its own header")
        channel, _, log_time, _ = MESSAGE.unpack_from(body)
        if channel not in self.channels:
            raise CorruptError(f"the message at byte {at} belongs to no channel")
        topic, wanted = self.channels[channel]
        if wanted:
            topic.log_time_ns.append(log_time)
            topic.order.append(self.counter)
            try:
                topic.data.append(plain_message(bytes(body[MESSAGE.size :])))
            except ValueError as error:
                raise CorruptError(f"the message at byte {at} {error}") from None
        self.counter += 1

    def _chunk(self, body: memoryview, at: int) -> None:
        size, crc, compression, packed = _chunk_parts(body)
        if packed is None:
            raise CorruptError(f"the chunk at byte {at} is shorter than it says")
        if size > LARGEST_CHUNK:
            raise CorruptError(f"the chunk at byte {at} claims {size} bytes")
        data = _unpack(compression, packed, size, f"chunk at byte {at}")
        if len(data) != size or (crc and zlib.crc32(data) != crc):
            raise CorruptError(f"the chunk at byte {at} does not have its size or checksum")
        end = self._inner(data, at)
        if end != len(data):
            raise CorruptError(f"a record runs over the end of the chunk at byte {at}")

    def _cut_chunk(self, body: memoryview) -> None:
        """Of a chunk that the file's end cuts off: all messages that are whole in it."""
        size, _, compression, packed = _chunk_parts(body, cut=True)
        if packed is not None:
            size = min(size, LARGEST_CHUNK)
            self._inner(_unpack(compression, packed, size, "last chunk"), len(body))

    def _inner(self, data: bytes, at: int) -> int:
        """Walk the records of a chunk; returns where the last whole one ends."""
        position = 0
        view = memoryview(data)
        while position + RECORD.size <= len(data):
            opcode, length = RECORD.unpack_from(data, position)
            start = position + RECORD.size
            if start + length > len(data):
                break
            if opcode == OP_MESSAGE:
                self._message(view[start : start + length], at)
            elif opcode in (OP_SCHEMA, OP_CHANNEL):
                self._record(opcode, view[start : start + length], at)
            position = start + length
        return position


def parsed(kind: str, body: memoryview, at: int) -> Any:
    from mcap import records
    from mcap.data_stream import ReadDataStream
    from mcap.exceptions import McapError

    try:
        return getattr(records, kind).read(ReadDataStream(BytesIO(bytes(body))))
    except (McapError, struct.error, UnicodeDecodeError, MemoryError, OverflowError):
        raise CorruptError(f"the {kind} record at byte {at} does not parse") from None


def _chunk_parts(body: memoryview, *, cut: bool = False) -> tuple[int, int, str, memoryview | None]:
    """Uncompressed size, CRC, compression and packed records of a chunk.

    The records are None where the body ends before them, or, unless `cut`, within them.
    """
    at = CHUNK.size + 4
    if len(body) < at:
        return 0, 0, "", None
    _, _, size, crc = CHUNK.unpack_from(body)
    (letters,) = struct.unpack_from("<I", body, CHUNK.size)
    if len(body) < at + letters + 8:
        return size, crc, "", None
    compression = bytes(body[at : at + letters]).decode("ascii", "replace")
    (length,) = struct.unpack_from("<Q", body, at + letters)
    packed = body[at + letters + 8 :][:length]
    return size, crc, compression, packed if cut or len(packed) == length else None


def _unpack(compression: str, data: memoryview, size: int, what: str) -> bytes:
    """Decompress as far as the data goes: a cut stream gives its whole blocks.

    Stops beyond `size` bytes, what the chunk says it holds, however much more there were.
    """
    unpackers: dict[str, Callable[[memoryview, int], bytes]] = {
        "": lambda packed, _: bytes(packed),
        "zstd": _unpack_zstd,
        "lz4": _unpack_lz4,
    }
    if compression not in unpackers:
        raise CorruptError(
            f"the {what} is compressed by {compression[:20]!r}, expected zstd or lz4"
        )
    try:
        return unpackers[compression](data, size + 1)
    except (ValueError, RuntimeError, MemoryError):
        raise CorruptError(f"the {what} does not decompress") from None


def _unpack_zstd(data: memoryview, most: int) -> bytes:
    import zstandard

    try:
        with zstandard.ZstdDecompressor().stream_reader(data) as stream:
            parts = []
            while most > 0 and (part := stream.read(most)):
                parts.append(part)
                most -= len(part)
            return parts[0] if len(parts) == 1 else b"".join(parts)
    except zstandard.ZstdError as error:
        raise ValueError(error) from None


def _unpack_lz4(data: memoryview, most: int) -> bytes:
    import lz4.frame

    return bytes(lz4.frame.LZ4FrameDecompressor().decompress(data, most))
