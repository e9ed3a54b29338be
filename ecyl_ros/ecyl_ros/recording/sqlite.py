"""Messages of a sqlite3 bag file, through rosbags."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from pathlib import Path
from types import TracebackType
from typing import Any

from ..errors import InputError
from .bag_contents import Bag, TopicMessages
from .packed import plain_message

ROWS = 65_536  # held at a time


class SqliteFile:
    """One `*.db3` file; its topics are put into the bag when it is opened.

    Attributes:
        topics: by their id in the file.

    Raises InputError where the file is none, or damaged.
    """

    def __init__(self, file: Path, bag: Bag) -> None:
        from rosbags.rosbag2.storage_sqlite3 import Sqlite3Reader

        self.file = file
        self._bag = bag
        self._reader: Any = Sqlite3Reader(file)
        self.topics: dict[int, TopicMessages] = {}
        self.message_count = 0

    def __enter__(self) -> SqliteFile:
        try:
            with self.file.open("rb") as stream:
                if not stream.read(1):
                    raise InputError(f"{self.file}: is empty, expected a sqlite3 bag")
        except OSError as error:
            raise InputError(f"{self.file}: cannot be read: {error.strerror}") from None
        try:
            self._reader.open()
            connections = list(self._reader.connections)
            self.message_count = int(self._reader.metadata.message_count)
        except InputError:
            raise
        # Whatever a damaged database makes of its tables: apsw raises errors of its own, rosbags
        # those of the values that it finds in the wrong places.
        except Exception as error:
            raise InputError(f"{self.file}: is no sqlite3 bag: {_reason(error)}") from None
        log = self.file.with_name(f"{self.file.name}-wal")
        if log.is_file() and log.stat().st_size:
            self._bag.notes += (
                f"{self.file}: {log.name} beside it holds messages that were not yet moved into "
                "the bag: they are not read",
            )
        for one in connections:
            self.topics[one.id] = self._topic(one)
        return self

    def _topic(self, connection: Any) -> TopicMessages:
        from rosbags.interfaces import MessageDefinitionFormat

        texts = (connection.topic, connection.msgtype, connection.ext.serialization_format)
        if not all(isinstance(text, str) for text in texts):
            raise InputError(f"{self.file}: topic {connection.id}: its name or type is no text")
        encodings = {
            MessageDefinitionFormat.MSG: "ros2msg",
            MessageDefinitionFormat.IDL: "ros2idl",
        }
        made = TopicMessages(
            name=connection.topic,
            type=connection.msgtype,
            encoding=connection.ext.serialization_format,
            qos=_qos_yaml(connection.ext.offered_qos_profiles),
            definition=str(connection.msgdef.data or ""),
            definition_encoding=encodings.get(connection.msgdef.format, ""),
        )
        known = self._bag.topics.setdefault(made.name, made)
        if known.type != made.type:
            raise InputError(
                f"{self.file}: {made.name} is {known.type} in one place and {made.type} in another"
            )
        return known

    def columns(
        self, start_ns: int | None = None, stop_ns: int | None = None
    ) -> Iterator[tuple[list[int], list[int], list[bytes]]]:
        """Topics' ids, log times in ns and data of messages within [start, stop), some at a time.

        In the order of the file, that of recording: by time the database would have to jump about
        in it (`+` keeps it from taking the index). Rows are taken apart at once: tens of thousands
        of tuples would keep the garbage collector busy for longer than all the rest.
        """
        if not self.topics:
            return
        bounds = (0 if start_ns is None else start_ns, 2**63 - 1 if stop_ns is None else stop_ns)
        try:
            found = self._reader.dbconn.execute(
                "SELECT topic_id, timestamp, data FROM messages "
                "WHERE +timestamp >= ? AND +timestamp < ? ORDER BY rowid",
                bounds,
            )
            while True:
                ids: list[int] = []
                stamps: list[int] = []
                messages: list[bytes] = []
                for topic, stamp, data in itertools.islice(found, ROWS):
                    ids.append(topic)
                    stamps.append(stamp)
                    messages.append(data)
                if not ids:
                    return
                kinds = [set(map(type, column)) for column in (ids, stamps, messages)]
                if kinds != [{int}, {int}, {bytes}] or not set(ids) <= set(self.topics):
                    raise InputError(f"{self.file}: damaged: a message that is none")
                yield ids, stamps, messages
        except InputError:
            raise
        except Exception as error:
            raise InputError(f"{self.file}: damaged: {_reason(error)}") from None

    def messages(self) -> Iterator[tuple[TopicMessages, int, bytes]]:
        """Topic, log time in ns and data of each message, in the order of the file."""
        for columns in self.columns():
            for topic, stamp, data in zip(*columns, strict=True):
                try:
                    yield self.topics[topic], stamp, plain_message(data)
                except ValueError as error:
                    raise InputError(f"{self.file}: damaged: a message {error}") from None

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._reader.dbconn is not None:
            self._reader.close()


def _reason(error: Exception) -> str:
    text = " ".join(str(error).split())
    return (text or type(error).__name__)[:160]


def _qos_yaml(profiles: Any) -> str:
    """As `TopicMessages.qos` has it: of the durability alone, which is what playback asks for."""
    import yaml

    try:
        names = [{"durability": one.durability.name.lower()} for one in profiles]
    except AttributeError:
        return ""
    return str(yaml.safe_dump(names)) if names else ""
