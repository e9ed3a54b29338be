"""What stands at the end of an MCAP file while it is written, so that it opens if that is all.

After every chunk the writer puts an end mark behind it and lets the next chunk overwrite that. A
file whose writer was killed is then a valid MCAP file without an index: the `mcap` library, `ros2
bag` and Foxglove read it from front to back. It lacks what the open chunk held, and it says so in
a metadata record. A closed file has none of this.
"""

from __future__ import annotations

from functools import cache
from typing import BinaryIO

NAME = "ecyl_ros"
STATE = {"state": "not closed: the messages after the last chunk are missing"}


@cache
def ending() -> bytes:
    """Metadata, end of data, a footer that promises no index, and the end mark."""
    from mcap.data_stream import RecordBuilder
    from mcap.records import DataEnd, Footer, Metadata
    from mcap.writer import MCAP0_MAGIC

    records = RecordBuilder()
    Metadata(name=NAME, metadata=STATE).write(records)
    DataEnd(data_section_crc=0).write(records)
    Footer(summary_start=0, summary_offset_start=0, summary_crc=0).write(records)
    return bytes(records.end()) + MCAP0_MAGIC


def put(stream: BinaryIO) -> None:
    """Write the ending where the stream stands, on to the operating system, and step back."""
    at = stream.tell()
    stream.write(ending())
    stream.flush()
    stream.seek(at)


def is_at_end(stream: BinaryIO, size: int) -> bool:
    """Whether a file of this size, bytes, ends so; moves the stream."""
    if size < len(ending()):
        return False
    stream.seek(size - len(ending()))
    return stream.read() == ending()
