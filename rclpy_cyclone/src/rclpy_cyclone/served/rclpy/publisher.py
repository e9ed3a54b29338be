"""Publishers."""

from __future__ import annotations

import time
from collections import deque
from typing import Any

from rclpy._ready import Ready
from rclpy.duration import Duration
from rclpy_cyclone.dds import clib, intra
from rclpy_cyclone.dds.participant import matched_readers, write
from rclpy_cyclone.dds.qos import Policies
from rclpy_cyclone.types import cdr, copying

_UNASKED = 64  # messages written without asking again whether anybody listens
_FOR_EVER = Duration(seconds=-1)
_count = clib.quick.dds_get_matched_subscriptions


class Publisher(Ready):
    """Sends messages to a topic. Nodes offer ``create_publisher`` for this."""

    def __init__(
        self,
        node: Any,
        msg_type: Any,
        topic: str,
        qos_profile: Any,
        event_callbacks: Any,
        callback_group: Any,
        policies: Policies,
        full_topic: str,
    ) -> None:
        super().__init__()
        self.msg_type = msg_type
        self.topic = topic
        self.qos_profile = qos_profile
        self.event_handlers: list[Any] = []
        self._node_entry = node._entry
        self._participant = node._participant
        self._context = node.context
        self._policies = policies
        self._full_topic = full_topic
        self._copy = copying.copier(msg_type._ros_name)
        self._encode = cdr.codec_of(msg_type)[0]
        # Late joiners elsewhere and DDS's own clocks need every sample written.
        self._always = policies.transient_local or policies.timed()
        self._history: deque[Any] | None = None
        if policies.transient_local:
            self._history = deque(maxlen=None if policies.keep_all else max(policies.depth, 1))
        self._unasked = 0
        self._local: tuple[Any, ...] = ()  # subscriptions served without DDS
        prefix = "" if qos_profile.avoid_ros_namespace_conventions else "rt"
        self._dds_topic = prefix + full_topic
        self._writer = self._participant.writer(self._dds_topic, msg_type._ros_name, policies)
        self._gid = clib.guid(self._writer)
        self._node_entry.writers.append(self._gid)
        self.event_handlers = event_callbacks.create_event_handlers(
            callback_group, self, topic, node.get_logger()
        )
        intra.add_publisher(self._participant, self)

    def publish(self, msg: Any) -> None:
        """Send a message.

        :param msg: a message of the publisher's type, or its CDR representation as ``bytes``.
        :raises TypeError: if it is something else.
        :raises InvalidHandle: if the publisher was destroyed.
        """
        if msg.__class__ is bytes:
            self._publish_raw(msg)
            return
        if msg.__class__ is not self.msg_type and not isinstance(msg, self.msg_type):
            self._publish_raw(msg)
            return
        if self._destroyed:
            self._alive()
        for sub in self._local:
            if sub._plain:
                sub._put(self._copy(msg))
            else:
                content = bytes(self._encode(msg)) if sub.raw else self._copy(msg)
                now = time.time_ns()
                sub._put((content, now, now))
        if self._always:
            if self._history is not None:
                self._history.append(self._copy(msg))
            write(self._writer, self._encode(msg))
        elif self._heard():
            write(self._writer, self._encode(msg))

    def _heard(self) -> bool:
        """Say whether anybody out there listens, or did a few messages ago."""
        if self._unasked:
            self._unasked -= 1
            return True
        if _count(self._writer, None, 0):
            self._unasked = _UNASKED
            return True
        return False

    def _publish_raw(self, data: Any) -> None:
        if not isinstance(data, bytes):
            raise TypeError(f"Expected {self.msg_type}, got {type(data)}")
        if self._destroyed or self._participant.closed:
            self._alive()
        for sub in self._local:
            if sub._info:
                now = time.time_ns()
                sub._put((data, now, now))
            else:
                sub._put(data)
        if self._history is not None:
            self._history.append(data)
        if self._always or self._heard():
            write(self._writer, data)

    def _serve_history(self, sub: Any) -> None:
        """Give a late subscription of this process what was published before."""
        now = time.time_ns()
        for msg in list(self._history or ()):
            if isinstance(msg, bytes):
                sub._put((msg, now, now))
            elif sub.raw:
                sub._put((bytes(self._encode(msg)), now, now))
            else:
                sub._put((self._copy(msg), now, now))

    def get_subscription_count(self) -> int:
        """Return how many subscriptions the publisher is matched with."""
        self._alive()
        return matched_readers(self._writer) + len(self._local)

    def _alive(self) -> None:
        if self._destroyed or self._participant.closed:
            from rclpy.exceptions import InvalidHandle

            raise InvalidHandle("cannot use Destroyable because destruction was requested")

    @property
    def topic_name(self) -> str:
        """Full name of the topic, remapped."""
        self._alive()
        return self._full_topic

    def destroy(self) -> None:
        """Release the publisher; nodes offer ``destroy_publisher`` for this."""
        if self._destroyed:
            return
        for handler in self.event_handlers:
            handler.destroy()
        super().destroy()
        intra.remove_publisher(self._participant, self)
        if self._gid in self._node_entry.writers:
            self._node_entry.writers.remove(self._gid)
        if not self._participant.closed:
            clib.delete(self._writer)

    def assert_liveliness(self) -> None:
        """Show life, as ``MANUAL_BY_TOPIC`` asks for within the lease duration."""
        self._alive()
        clib.check(clib.blocking.dds_assert_liveliness(self._writer), "assert liveliness")

    def wait_for_all_acked(self, timeout: Duration = _FOR_EVER) -> bool:
        """Wait until all matched subscriptions have what was published.

        :param timeout: how long to wait; for ever if negative.
        :return: whether they have it; ``True`` at once for a best effort publisher.
        """
        self._alive()
        limit = timeout.nanoseconds
        result = clib.blocking.dds_wait_for_acks(
            self._writer, clib.INFINITY if limit < 0 else limit
        )
        if result == -10:
            return False
        clib.check(result, "wait for acknowledgement")
        return True
