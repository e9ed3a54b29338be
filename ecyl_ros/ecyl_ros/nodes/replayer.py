"""The replayer node: a bag's messages on their topics again, as the bytes they were recorded as."""

from __future__ import annotations

import importlib
import time
from collections.abc import Callable, Mapping
from typing import Any

import yaml
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rosgraph_msgs.msg import Clock

from ..errors import InputError
from ..recording.bag_contents import Bag, TopicMessages
from ..recording.timeline import NANOSECONDS, Event, Timeline

CLOCK = "/clock"
DEPTH = 1000  # messages that a slow subscriber may lag behind before it loses some
NAP_S = 0.1  # longest sleep, after which a shutdown is noticed
PROGRESS_S = 0.1
ACKNOWLEDGE_S = 2


class Replayer(Node):
    """Publishes a timeline's events when they are due.

    Args:
        bag: where the topics' types and QoS come from.
        timeline: what is due when.
        remap: topic in the bag -> topic to publish on.
        names: topics to publish; those of the bag by default.
        options: of rclpy's Node.

    Attributes:
        published: messages sent so far, clock ticks aside.
        latest_s: by how much the latest message was behind its due time.

    Raises:
        InputError: a message type whose package is not installed, or an encoding other than CDR.
    """

    def __init__(
        self,
        bag: Bag,
        timeline: Timeline,
        *,
        remap: Mapping[str, str] | None = None,
        names: list[str] | None = None,
        clock: bool = False,
        **options: Any,
    ) -> None:
        super().__init__("ecyl_replayer", start_parameter_services=False, **options)
        self._timeline = timeline
        names = sorted(bag.topics) if names is None else names
        own = dict(remap or {})
        self._outputs = {
            name: self.create_publisher(
                _message_class(bag, bag.topics[name]), own.get(name, name), _qos(bag.topics[name])
            )
            for name in names
        }
        # `_clock` is rclpy's own.
        self._clock_output = self.create_publisher(Clock, CLOCK, 10) if clock else None
        self.published = 0
        self.latest_s = 0.0

    def wait_for_subscribers(self, timeout_s: float) -> bool:
        """Until each topic has a subscriber, but no longer than timeout_s; whether that is so."""
        limit = time.monotonic() + timeout_s
        while self.context.ok():
            if all(output.get_subscription_count() for output in self._outputs.values()):
                return True
            if time.monotonic() >= limit:
                return False
            time.sleep(0.02)
        return False

    def wait(self, seconds: float) -> None:
        """Sleep, no longer than until a shutdown."""
        self._sleep_until(time.monotonic_ns() + round(seconds * NANOSECONDS))

    def play(self, progress: Callable[[float], None] = lambda share: None) -> bool:
        """Publish all of the timeline; False where a shutdown came before its end."""
        begin = time.monotonic_ns()
        duration = max(self._timeline.duration_ns, 1)
        next_progress = 0.0
        for event in self._timeline:
            late_ns = self._sleep_until(begin + event.due_ns)
            if late_ns is None:
                return False
            self._publish(event)
            self.latest_s = max(self.latest_s, late_ns / NANOSECONDS)
            now = time.monotonic()
            if now >= next_progress:
                progress(event.due_ns % (duration + 1) / duration)
                next_progress = now + PROGRESS_S
        for output in self._outputs.values():
            output.wait_for_all_acked(Duration(seconds=ACKNOWLEDGE_S))
        return True

    def _sleep_until(self, due_ns: int) -> int | None:
        """Sleep and return by how much it is late; None on shutdown."""
        while self.context.ok():
            left = due_ns - time.monotonic_ns()
            if left <= 0:
                return -left
            time.sleep(min(left / NANOSECONDS, NAP_S))
        return None

    def _publish(self, event: Event) -> None:
        if event.topic is None:
            assert self._clock_output is not None
            message = Clock()
            message.clock.sec, message.clock.nanosec = divmod(event.bag_ns, NANOSECONDS)
            self._clock_output.publish(message)
            return
        self._outputs[event.topic].publish(event.data)
        self.published += 1


def _message_class(bag: Bag, topic: TopicMessages) -> type:
    if topic.encoding != "cdr":
        raise InputError(
            f"{bag.path}: {topic.name}: encoding is {topic.encoding!r}, expected 'cdr'"
        )
    package, _, name = topic.type.partition("/msg/")
    try:
        found: type = getattr(importlib.import_module(f"{package}.msg"), name)
    except (ImportError, AttributeError, ValueError):
        why = f"type {topic.type} is not installed; leave it out by --topics"
        raise InputError(f"{bag.path}: {topic.name}: {why}") from None
    return found


def _qos(topic: TopicMessages) -> QoSProfile:
    """Reliable, which suits every subscriber; latched where all recorded publishers were."""
    try:
        offered = yaml.safe_load(topic.qos) or []
        # Older bags give numbers; 1 is transient local.
        latched = bool(offered) and all(o["durability"] in ("transient_local", 1) for o in offered)
    except (yaml.YAMLError, KeyError, TypeError):
        latched = False  # what the recorder noted cannot be read: the default of a publisher
    durability = DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE
    return QoSProfile(depth=DEPTH, reliability=ReliabilityPolicy.RELIABLE, durability=durability)
