"""What a bag holds: raw messages by topic."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path


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
