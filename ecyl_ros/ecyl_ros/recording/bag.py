"""Raw messages of a bag: MCAP and sqlite3, file or rosbag2 folder, also when it was cut off."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path

from .bag_contents import Bag
from .bag_files import SQLITE, bag_files, called
from .mcap_file import FileReader
from .packed import kind, plain_file
from .sqlite import SqliteFile


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


def _take_sqlite(file: Path, bag: Bag, topics: Collection[str] | None, counter: int) -> int:
    with SqliteFile(file, bag) as source:
        for topic, log_time, data in source.messages():
            if topics is None or topic.name in topics:
                topic.log_time_ns.append(log_time)
                topic.order.append(counter)
                topic.data.append(data)
            counter += 1
    return counter
