"""A recording whose writer was killed, rewritten as a closed file with an index."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ..errors import InputError
from .atomic import replacing
from .bag_contents import Bag
from .bag_files import SQLITE, bag_files
from .mcap_file import MESSAGE, OP_CHANNEL, OP_SCHEMA, CorruptError, FileReader, parsed
from .packed import kind, plain_file
from .writer import CHUNK_BYTES, PROFILE


class _Mender(FileReader):
    """Hands every whole message on to a writer as it is read, bytes and times unchanged."""

    def __init__(self, file: Path, bag: Bag, writer: Any, counter: int) -> None:
        super().__init__(file, bag, counter=counter)
        self._writer = writer
        self._schemas: dict[int, int] = {}  # id in the file read -> id in the one written
        self._channels: dict[int, int] = {}

    def _record(self, opcode: int, body: memoryview, at: int) -> None:
        super()._record(opcode, body, at)
        if opcode == OP_SCHEMA:
            schema = parsed("Schema", body, at)
            if schema.id not in self._schemas:
                new = self._writer.register_schema(schema.name, schema.encoding, schema.data)
                self._schemas[schema.id] = new
        elif opcode == OP_CHANNEL:
            channel = parsed("Channel", body, at)
            if channel.id not in self._channels:
                self._channels[channel.id] = self._writer.register_channel(
                    channel.topic,
                    channel.message_encoding,
                    self._schemas[channel.schema_id],
                    channel.metadata,
                )

    def _message(self, body: memoryview, at: int) -> None:
        if len(body) < MESSAGE.size:
            raise CorruptError(f"the message at byte {at} is shorter than its own header")
        channel, sequence, log_time, publish_time = MESSAGE.unpack_from(body)
        if channel not in self._channels:
            raise CorruptError(f"the message at byte {at} belongs to no channel")
        data = bytes(body[MESSAGE.size :])
        self._writer.add_message(self._channels[channel], log_time, data, publish_time, sequence)
        self.counter += 1


def mend(source: Path, target: Path) -> tuple[int, tuple[str, ...]]:
    """Write all whole messages of `source` to `target`, a closed MCAP file.

    Args:
        source: MCAP file, or rosbag2 folder of such.
        target: file to write, there whole or not at all.

    Returns:
        Messages kept, and what was found to be cut off or not closed (empty: nothing was).

    Raises:
        InputError: `source` is no MCAP recording, or is damaged other than by being cut off.
    """
    from mcap.writer import CompressionType, Writer

    bag = Bag(source)
    files = bag_files(source)
    counter = 0
    with replacing(target) as temporary, temporary.open("wb") as stream:
        writer = Writer(stream, chunk_size=CHUNK_BYTES, compression=CompressionType.ZSTD)
        writer.start(PROFILE)
        for file in files:
            if kind(file) == SQLITE:
                raise InputError(f"{file}: is an sqlite3 bag, expected MCAP: it needs no mending")
            with plain_file(file) as plain:
                reader = _Mender(plain, bag, writer, counter)
                for _ in reader.steps():
                    pass
                counter = reader.counter
        writer.finish()
    return counter, tuple(note.replace(" whole messages kept", " messages") for note in bag.notes)
