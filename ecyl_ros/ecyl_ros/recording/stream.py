"""A bag's messages some megabytes at a time, framed by compiled code."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from ..arrays import StampArray
from ..errors import InputError
from .bag_contents import Bag, TopicMessages
from .bag_files import SQLITE, bag_files, called
from .mcap_file import (
    CHUNK,
    FOOTER,
    MAGIC,
    OP_CHANNEL,
    OP_CHUNK,
    OP_FOOTER,
    OP_SCHEMA,
    RECORD,
    CorruptError,
    FileReader,
)
from .packed import FRAME, kind, plain_file, plain_message

BATCH_BYTES = 8 * 2**20
_BATCH_MESSAGES = 65_536


@dataclass(frozen=True)
class Batch:
    """Some messages of one topic, in file order.

    Attributes:
        topic: name, type and definition; it holds no messages.
        log_time_ns: int64[k].
        data: uint8, in which message i has the bytes start[i] up to start[i] + length[i].
        start, length: int64[k].
    """

    topic: TopicMessages
    log_time_ns: StampArray
    data: NDArray[np.uint8]
    start: NDArray[np.int64]
    length: NDArray[np.int64]

    def message(self, index: int) -> bytes:
        """One message's bytes."""
        begin = int(self.start[index])
        return self.data[begin : begin + int(self.length[index])].tobytes()


class BagStream:
    """Batches of a bag, file after file.

    Args:
        path: as `read_bag` takes it.
        topics: names of those wanted; all by default.
        start_ns, stop_ns: log times outside [start, stop) may be left out, by chunk.

    Attributes:
        bag: topics met and notes; complete at the end.
        share: of the bag's bytes gone through so far, 0 to 1; a sqlite file counts when it is done.

    Raises:
        InputError: as `read_bag`, while iterating.
    """

    def __init__(
        self,
        path: str | Path,
        *,
        topics: Collection[str] | None = None,
        start_ns: int | None = None,
        stop_ns: int | None = None,
    ) -> None:
        self.bag = Bag(Path(path))
        self._topics = topics
        self._window = (start_ns, stop_ns)
        self.share = 0.0

    def __iter__(self) -> Iterator[Batch]:
        from . import kernels  # noqa: F401  (numba is imported before a file is opened)

        files = bag_files(self.bag.path)
        for number, file in enumerate(files):
            with plain_file(file) as plain, called(self.bag, plain, file):
                if kind(file) == SQLITE:
                    yield from self._sqlite(plain)
                else:
                    size = max(plain.stat().st_size, 1)
                    for batch, at in self._mcap(plain):
                        self.share = (number + at / size) / len(files)
                        yield batch
            self.share = (number + 1) / len(files)

    def _mcap(self, file: Path) -> Iterator[tuple[Batch, int]]:
        """Batches, and how many bytes of the file were gone through for them."""
        reader = _ChunkReader(file, self.bag, self._topics, self._window)
        for _ in reader.steps():
            if reader.pending_bytes >= BATCH_BYTES or reader.loose >= _BATCH_MESSAGES:
                for batch in reader.taken():
                    yield _unpacked(batch), reader.at
        for batch in reader.taken():
            yield _unpacked(batch), reader.at

    def _sqlite(self, file: Path) -> Iterator[Batch]:
        from .sqlite import SqliteFile

        with SqliteFile(file, self.bag) as source:
            for ids, times, messages in source.columns(*self._window):
                lengths = np.fromiter(map(len, messages), dtype=np.int64, count=len(ids))
                starts = np.cumsum(lengths) - lengths
                data = np.frombuffer(b"".join(messages), dtype=np.uint8)
                stamps, numbers = np.array(times, dtype=np.int64), np.array(ids, dtype=np.int64)
                for number, topic in source.topics.items():
                    own = np.flatnonzero(numbers == number)
                    if own.size and (self._topics is None or topic.name in self._topics):
                        found = Batch(topic, stamps[own], data, starts[own], lengths[own])
                        yield _unpacked(found)


def _unpacked(batch: Batch) -> Batch:
    """The batch with its messages unpacked, where they are packed one by one."""
    if not batch.message(0).startswith(FRAME):
        return batch
    try:
        messages = [plain_message(batch.message(i)) for i in range(batch.start.size)]
    except ValueError as error:
        raise InputError(f"{batch.topic.name}: a message {error}") from None
    return joined(batch.topic, batch.log_time_ns.tolist(), messages)


def joined(topic: TopicMessages, times: list[int], messages: list[bytes]) -> Batch:
    """A batch of single messages."""
    lengths = np.fromiter(map(len, messages), dtype=np.int64, count=len(messages))
    return Batch(
        topic,
        np.array(times, dtype=np.int64),
        np.frombuffer(b"".join(messages), dtype=np.uint8),
        np.cumsum(lengths) - lengths,
        lengths,
    )


class _ChunkReader(FileReader):
    """Frames whole chunks at once and keeps them until they are taken."""

    def __init__(
        self,
        file: Path,
        bag: Bag,
        topics: Collection[str] | None,
        window: tuple[int | None, int | None],
    ) -> None:
        super().__init__(file, bag, topics)
        self.window = window
        self.chunks: list[bytes] = []
        self.frames: list[NDArray[np.int64]] = []  # channel, log time, start, length
        self.pending_bytes = 0
        self.loose = 0  # messages outside chunks
        self.known = np.zeros(2**16, dtype=np.bool_)  # whether a channel of this id was announced
        self.announced = 0

    def _read(self, stream: BinaryIO, size: int) -> Iterator[None]:
        # Channels are announced once, in a chunk that may be skipped, and again at the end.
        if self.window != (None, None) and not self._announced(stream, size):
            self.window = (None, None)
        stream.seek(0)
        yield from super()._read(stream, size)

    def _announced(self, stream: BinaryIO, size: int) -> bool:
        """Take in the channels of the file's summary; whether there is one."""
        if size < FOOTER.size + 2 * len(MAGIC):
            return False
        stream.seek(size - FOOTER.size - len(MAGIC))
        opcode, _, start, _, _ = FOOTER.unpack(stream.read(FOOTER.size))
        end = size - FOOTER.size - len(MAGIC)
        if opcode != OP_FOOTER or stream.read() != MAGIC or not len(MAGIC) < start < end:
            return False
        while start + RECORD.size <= end:
            stream.seek(start)
            opcode, length = RECORD.unpack(stream.read(RECORD.size))
            if start + RECORD.size + length > end:
                break
            if opcode in (OP_SCHEMA, OP_CHANNEL):
                self._record(opcode, memoryview(stream.read(length)), start)
            start += RECORD.size + length
        return bool(self.channels)

    def _needed(self, opcode: int, stream: BinaryIO, length: int) -> bool:
        start, stop = self.window
        if opcode != OP_CHUNK or (start is None and stop is None) or length < CHUNK.size:
            return True
        at = stream.tell()
        first, last, _, _ = CHUNK.unpack(stream.read(CHUNK.size))
        stream.seek(at)
        return (start is None or last >= start) and (stop is None or first < stop)

    def _check_count(self, counted: int) -> None:
        if self.window == (None, None):
            super()._check_count(counted)

    def _message(self, body: memoryview, at: int) -> None:
        # Outside chunks, as a chunk of its own.
        self._inner(RECORD.pack(5, len(body)) + bytes(body), at)
        self.loose += 1

    def _inner(self, data: bytes, at: int) -> int:
        from .kernels import framed

        channels, times, starts, lengths, others, end = framed(data)
        view = memoryview(data)
        for place in others.tolist():
            opcode, length = RECORD.unpack_from(data, place)
            if opcode in (OP_SCHEMA, OP_CHANNEL):
                begin = place + RECORD.size
                self._record(opcode, view[begin : begin + length], at)
        if channels.size:
            if (lengths < 0).any():
                raise CorruptError(f"a message at byte {at} is shorter than its own header")
            if (times < 0).any():
                raise CorruptError(f"a message at byte {at} has a log time beyond 2**63 ns")
            if len(self.channels) != self.announced:
                self.known[list(self.channels)] = True
                self.announced = len(self.channels)
            if not self.known[channels].all():
                raise CorruptError(f"a message at byte {at} belongs to no channel")
            self.chunks.append(data)
            self.frames.append(np.array((channels, times, starts + self.pending_bytes, lengths)))
            self.pending_bytes += len(data)
            self.counter += int(channels.size)
        return end

    def taken(self) -> list[Batch]:
        """What has been read since the last call, one batch per topic."""
        if not self.chunks:
            return []
        data = np.frombuffer(
            self.chunks[0] if len(self.chunks) == 1 else b"".join(self.chunks), dtype=np.uint8
        )
        channels, times, starts, lengths = np.concatenate(self.frames, axis=1)
        self.chunks.clear()
        self.frames.clear()
        self.pending_bytes = self.loose = 0
        # Several channels of one topic (one per publisher) stay in file order.
        names = {key: topic.name for key, (topic, wanted) in self.channels.items() if wanted}
        batches = []
        for name in dict.fromkeys(names.values()):
            keys = [key for key, own in names.items() if own == name]
            rows = np.flatnonzero(np.isin(channels, keys) if len(keys) > 1 else channels == keys[0])
            if rows.size:
                topic = self.channels[keys[0]][0]
                batches.append(Batch(topic, times[rows], data, starts[rows], lengths[rows]))
        return batches
