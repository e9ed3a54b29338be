"""Subscriptions."""

from __future__ import annotations

import inspect
import time
from collections import deque
from collections.abc import Callable
from enum import Enum
from typing import Any

from rclpy._ready import Ready
from rclpy_cyclone.dds import clib, intra
from rclpy_cyclone.dds.participant import take
from rclpy_cyclone.dds.qos import Policies
from rclpy_cyclone.types import cdr

_Wire = tuple  # entries of the queue with information: (content, source stamp, receipt stamp)


class Subscription(Ready):
    """Receives messages of a topic. Nodes offer ``create_subscription`` for this."""

    _queued: bool

    class CallbackType(Enum):
        """What the callback wants."""

        MessageOnly = 0
        WithMessageInfo = 1

    def __init__(
        self,
        node: Any,
        msg_type: Any,
        topic: str,
        callback: Callable[..., Any],
        callback_group: Any,
        qos_profile: Any,
        raw: bool,
        event_callbacks: Any,
        policies: Policies,
        full_topic: str,
    ) -> None:
        super().__init__()
        self.msg_type = msg_type
        self.topic = topic
        self.raw = raw
        self.callback = callback
        self.callback_group = callback_group
        self.qos_profile = qos_profile
        self.event_handlers: list[Any] = []
        self._node_entry = node._entry
        self._participant = node._participant
        self._policies = policies
        self._full_topic = full_topic
        limit = None if policies.keep_all else max(policies.depth, 1)
        self._queue: deque[Any] = deque(maxlen=limit)
        self._decode = cdr.decoder(msg_type)
        # Deadlines and the like are kept by DDS, which then has to see every sample.
        self._intra = not policies.timed()
        prefix = "" if qos_profile.avoid_ros_namespace_conventions else "rt"
        self._dds_topic = prefix + full_topic
        self._reader = self._participant.reader(
            self._dds_topic, msg_type._ros_name, policies, self._intra
        )
        condition = clib.blocking.dds_create_readcondition(self._reader, clib.ANY_STATE)
        self._waits.append((clib.check(condition, "create read condition"), self._drain))
        self._gid = clib.guid(self._reader)
        self._node_entry.readers.append(self._gid)
        self._local_publishers = 0
        self.event_handlers = event_callbacks.create_event_handlers(
            callback_group, self, topic, node.get_logger()
        )
        intra.add_subscription(self._participant, self)

    def _put(self, entry: Any) -> None:
        """Take in a message: one of our own, its bytes, or either with information on it."""
        self._queue.append(entry)
        if not self._queued:
            executor = self._executor
            if executor is not None:
                self._queued = True
                executor._make_ready(self)

    def _drain(self) -> None:
        """Take in what DDS received."""
        taken = take(self._reader)
        entries: list[Any]
        if self._info:
            now = time.time_ns()
            entries = [(data, i.source_timestamp, now) for data, i in taken if i.valid_data]
        else:
            entries = [data for data, i in taken if i.valid_data]
        if entries:
            self._queue.extend(entries)
            if not self._queued:
                self._ready()

    def _pending(self) -> bool:
        return bool(self._queue)

    def _take(self) -> tuple[Any, tuple[Any, ...]] | None:
        try:
            entry = self._queue.popleft()
        except IndexError:
            return None
        content, source, received = entry if entry.__class__ is _Wire else (entry, 0, 0)
        if content.__class__ is bytes and not self.raw:
            try:
                content = self._decode(content)
            except ValueError as error:
                self._complain(error)
                return None
        if not self._info:
            return self._callback, (content,)
        info = {
            "source_timestamp": source,
            "received_timestamp": received,
            "publication_sequence_number": None,
            "reception_sequence_number": None,
        }
        return self._callback, (content, info)

    def _complain(self, error: Exception) -> None:
        from rclpy.logging import get_logger

        get_logger("rclpy_cyclone").error(f"dropped a sample on {self._full_topic}: {error}")

    def get_publisher_count(self) -> int:
        """Return how many publishers the subscription is matched with."""
        self._alive()
        remote = clib.blocking.dds_get_matched_publications(self._reader, None, 0)
        return int(remote) + self._local_publishers

    def _alive(self) -> None:
        if self._destroyed:
            from rclpy.exceptions import InvalidHandle

            raise InvalidHandle("cannot use Destroyable because destruction was requested")

    def destroy(self) -> None:
        """Release the subscription; nodes offer ``destroy_subscription`` for this."""
        if self._destroyed:
            return
        for handler in self.event_handlers:
            handler.destroy()
        super().destroy()
        intra.remove_subscription(self._participant, self)
        if self._gid in self._node_entry.readers:
            self._node_entry.readers.remove(self._gid)
        if not self._participant.closed:
            clib.delete(self._reader)

    @property
    def topic_name(self) -> str:
        """Full name of the topic, remapped."""
        self._alive()
        return self._full_topic

    @property
    def callback(self) -> Callable[..., Any]:
        """The function that gets the messages."""
        return self._callback

    @callback.setter
    def callback(self, value: Callable[..., Any]) -> None:
        self._callback = value
        for kind, args in (
            (Subscription.CallbackType.MessageOnly, (0,)),
            (Subscription.CallbackType.WithMessageInfo, (0, 0)),
        ):
            try:
                inspect.signature(value).bind(*args)
            except TypeError:
                continue
            self._callback_type = kind
            self._info = kind is Subscription.CallbackType.WithMessageInfo
            self._plain = not self.raw and not self._info  # content alone will do
            return
        raise RuntimeError(
            "Subscription.__init__(): callback should be either be callable with one argument"
            "(to get only the message) or two (to get message and message info)"
        )
