"""Bags that rosbag2 compressed: each file, or each message, in a zstd frame of its own."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from ..errors import InputError

# A CDR message begins with 00, MCAP with 89, sqlite3 with an S: the frame tells itself.
FRAME = b"\x28\xb5\x2f\xfd"
SUFFIX = ".zstd"
LARGEST_MESSAGE = 2**28
_MOST_TIMES = 1000  # that a file may grow; recordings of a drive at rest grow a hundred times
_PIECE = 2**20


def kind(file: Path) -> str:
    """The suffix that says what a file is, once unpacked."""
    return Path(file.stem).suffix if file.suffix == SUFFIX else file.suffix


@contextmanager
def plain_file(file: Path) -> Iterator[Path]:
    """The file itself, or what it unpacks to, for as long as the block lasts.

    Raises:
        InputError: it cannot be read or does not unpack.
    """
    try:
        with file.open("rb") as stream:
            packed = stream.read(len(FRAME)) == FRAME
    except OSError as error:
        raise InputError(f"{file}: cannot be read: {error.strerror}") from None
    if not packed:
        yield file
        return
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder, Path(file.name).stem)
        _unpack_file(file, place)
        yield place


def _unpack_file(file: Path, place: Path) -> None:
    import zstandard

    room = _MOST_TIMES * file.stat().st_size
    try:
        with (
            file.open("rb") as source,
            place.open("wb") as target,
            zstandard.ZstdDecompressor().stream_reader(source) as stream,
        ):
            while piece := stream.read(_PIECE):
                room -= len(piece)
                if room < 0:
                    raise InputError(f"{file}: unpacks to more than {_MOST_TIMES} times its size")
                target.write(piece)
    except zstandard.ZstdError as error:
        raise InputError(f"{file}: does not unpack: {error}") from None
    except OSError as error:
        raise InputError(f"{file}: cannot be unpacked: {error.strerror}") from None


def plain_message(data: bytes) -> bytes:
    """The message, unpacked where it is packed. Raises ValueError where that fails."""
    if not data.startswith(FRAME):
        return data
    import zstandard

    try:
        with zstandard.ZstdDecompressor().stream_reader(data) as stream:
            out = bytes(stream.read(LARGEST_MESSAGE + 1))
    except zstandard.ZstdError as error:
        raise ValueError(f"does not unpack: {error}") from None
    if len(out) > LARGEST_MESSAGE:
        raise ValueError(f"unpacks to more than {LARGEST_MESSAGE} bytes")
    return out
