"""Raw messages of a bag: MCAP and sqlite3, file or rosbag2 folder, also when it was cut off.

The `mcap` package parses the records. Their framing is walked here, because its stream reader
hands out what is left of a record at the end of a cut file as if it were whole. One record is
held at a time. `rosbags` reads sqlite3.
"""

from __future__ import annotations

import contextlib
import re
import struct
import zlib
from collections.abc import Callable, Collection, Generator, Iterator
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from typing import Any, BinaryIO

import yaml

from ..errors import InputError
from . import unclosed
from .packed import kind, plain_file, plain_message

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
SQLITE = ".db3"


class CorruptError(ValueError):
    """Bytes that no writer leaves behind, not even one that was cut off."""


@dataclass
class TopicMessages:
    """All messages of one topic, in file order.

    Attributes:
        name, type: topic name and message type, `package/msg/Type`.
        encoding: of the messages; `cdr` in ROS 2.
        qos: the QoS profiles that its publishers offered, as YAML text; may be empty.
        definition: of the type, as the bag holds it; empty where it does not.
        definition_encoding: `ros2msg` or `ros2idl`.
        log_time_ns: one per message.
        order: position of each message among all messages of the bag.
        data: serialised messages.
    """

    name: str
    type: str
    encoding: str
    qos: str = ""
    definition: str = ""
    definition_encoding: str = ""
    log_time_ns: list[int] = field(default_factory=list)
    order: list[int] = field(default_factory=list)
    data: list[bytes] = field(default_factory=list)


@dataclass
class Bag:
    """What a recording holds: topics by name, and notes on what was cut off."""

    path: Path
    topics: dict[str, TopicMessages] = field(default_factory=dict)
    notes: tuple[str, ...] = ()

    @property
    def message_count(self) -> int:
        """Messages of all topics kept."""
        return sum(len(topic.data) for topic in self.topics.values())


def read_bag(path: str | Path, *, topics: Collection[str] | None = None) -> Bag:
    """Read a bag: an MCAP or sqlite3 file, or all files of a rosbag2 folder in their order.

    Args:
        path: `*.mcap`, `*.db3`, or a folder with such files, with or without metadata.yaml.
        topics: names of the topics to keep; all of them by default.

    Returns:
        Topics are listed even where they hold no message or were not asked for. A file that ends
        early, wherever that is, gives all that is whole up to there, and a note.

    Raises:
        InputError: no such file, no bag, damaged other than by being cut off, or a message
            encoding or compression that cannot be read.
    """
    bag = Bag(Path(path))
    counter = 0
    for file in bag_files(bag.path):
        with plain_file(file) as plain, called(bag, plain, file):
            if kind(file) == SQLITE:
                counter = _take_sqlite(plain, bag, topics, counter)
                continue
            reader = FileReader(plain, bag, topics, counter)
            for _ in reader.steps():
                pass
            counter = reader.counter
    return bag


@contextlib.contextmanager
def called(bag: Bag, plain: Path, file: Path) -> Iterator[None]:
    """Have errors and notes name the file that was given, not the one it was unpacked to."""
    try:
        yield
    except InputError as error:
        raise InputError(str(error).replace(str(plain), str(file))) from None
    finally:
        bag.notes = tuple(note.replace(str(plain), str(file)) for note in bag.notes)


def _take_sqlite(file: Path, bag: Bag, topics: Collection[str] | None, counter: int) -> int:
    from .sqlite import SqliteFile

    with SqliteFile(file, bag) as source:
        for topic, log_time, data in source.messages():
            if topics is None or topic.name in topics:
                topic.log_time_ns.append(log_time)
                topic.order.append(counter)
                topic.data.append(data)
            counter += 1
    return counter


def bag_files(path: Path) -> list[Path]:
    """The files of a bag in their order; see `read_bag` for what is raised."""
    if path.is_file():
        return [path]
    if not path.is_dir():
        raise InputError(
            f"{path}: no such file or folder; expected an MCAP or sqlite3 file or a rosbag2 folder"
        )
    metadata = path / "metadata.yaml"
    if metadata.is_file():
        return _listed(path, metadata)
    # A recorder that was killed leaves no metadata.yaml. Files are numbered: _2 before _10.
    found = sorted(
        [one for one in path.iterdir() if kind(one) in (".mcap", SQLITE)],
        key=lambda file: [int(w) if w.isdigit() else w for w in re.split(r"(\d+)", file.name)],
    )
    if not found:
        raise InputError(f"{path}: no recording: expected *.mcap or *{SQLITE} files in the folder")
    return found


def _listed(path: Path, metadata: Path) -> list[Path]:
    try:
        about = yaml.safe_load(metadata.read_text(encoding="utf-8"))["rosbag2_bagfile_information"]
        storage = about["storage_identifier"]
        names = [Path(name).name for name in about["relative_file_paths"]]
        packed = about.get("compression_format") or ""
    except OSError as error:
        raise InputError(f"{metadata}: cannot be read: {error.strerror}") from None
    except (
        yaml.YAMLError,
        ValueError,  # of a date that is none, or text that is no UTF-8
        RecursionError,
        KeyError,
        TypeError,
        AttributeError,
    ):
        raise InputError(
            f"{metadata}: expected rosbag2_bagfile_information with storage_identifier and "
            "relative_file_paths"
        ) from None
    if storage not in ("mcap", "sqlite3"):
        raise InputError(
            f"{metadata}: storage_identifier is {str(storage)[:40]!r}, expected mcap or sqlite3"
        )
    if packed not in ("", "zstd"):
        raise InputError(
            f"{metadata}: compression_format is {str(packed)[:40]!r}, expected zstd or none "
            "(`ros2 bag convert` undoes it)"
        )
    files = [path / name for name in names]
    for file in files:
        if not file.is_file():
            raise InputError(f"{metadata}: relative_file_paths names {file.name}, which is missing")
    if not files:
        raise InputError(f"{metadata}: relative_file_paths is empty, expected the names of files")
    return files


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


def in_time_order(bag: Bag) -> Iterator[tuple[int, str, bytes]]:
    """All messages kept as (log time in ns, topic name, data), by time, then in file order."""
    entries = [
        (log_time, order, topic.name, data)
        for topic in bag.topics.values()
        for log_time, order, data in zip(topic.log_time_ns, topic.order, topic.data, strict=True)
    ]
    entries.sort(key=lambda entry: entry[:2])
    for log_time, _, name, data in entries:
        yield log_time, name, data
