"""The files that a bag is made of, in their order."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Iterator
from pathlib import Path

import yaml

from ..errors import InputError
from .bag_contents import Bag
from .packed import kind

SQLITE = ".db3"


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


@contextlib.contextmanager
def called(bag: Bag, plain: Path, file: Path) -> Iterator[None]:
    """Have errors and notes name the file that was given, not the one it was unpacked to."""
    try:
        yield
    except InputError as error:
        raise InputError(str(error).replace(str(plain), str(file))) from None
    finally:
        bag.notes = tuple(note.replace(str(plain), str(file)) for note in bag.notes)
