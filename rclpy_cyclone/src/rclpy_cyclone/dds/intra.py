"""Exchange within a participant: which publishers serve which subscriptions without DDS.

A reader made for this ignores the participant's own writers, so no sample arrives twice. DDS
counts it among the matched readers all the same, hence a publisher writes to DDS only if more
readers are matched than it serves here.
"""

from __future__ import annotations

from typing import Any

from rclpy_cyclone.dds import qos


class _Topic:
    """The endpoints of one topic and type."""

    def __init__(self) -> None:
        self.publishers: list[Any] = []
        self.subscriptions: list[Any] = []

    def connect(self) -> None:
        for pub in self.publishers:
            pub._local = tuple(
                sub
                for sub in self.subscriptions
                if sub._intra and qos.refusal(pub._policies, sub._policies) is None
            )


def _topic(participant: Any, endpoint: Any) -> _Topic:
    key = (endpoint._dds_topic, endpoint.msg_type._ros_name)
    return participant.local_topics.setdefault(key, _Topic())


def add_publisher(participant: Any, pub: Any) -> None:
    """Let a publisher serve the subscriptions of its participant."""
    with participant.lock:
        topic = _topic(participant, pub)
        topic.publishers.append(pub)
        topic.connect()


def add_subscription(participant: Any, sub: Any) -> None:
    """Let a subscription be served; it gets what transient local publishers have kept."""
    with participant.lock:
        topic = _topic(participant, sub)
        topic.subscriptions.append(sub)
        topic.connect()
        if sub._policies.transient_local:
            for pub in topic.publishers:
                if sub in pub._local:
                    pub._serve_history(sub)


def remove_publisher(participant: Any, pub: Any) -> None:
    """Forget a publisher."""
    with participant.lock:
        topic = _topic(participant, pub)
        topic.publishers.remove(pub)
        pub._local = ()


def remove_subscription(participant: Any, sub: Any) -> None:
    """Forget a subscription."""
    with participant.lock:
        topic = _topic(participant, sub)
        topic.subscriptions.remove(sub)
        topic.connect()
