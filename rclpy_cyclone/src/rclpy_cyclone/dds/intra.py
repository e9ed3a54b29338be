"""Exchange within a participant: which publishers serve which subscriptions without DDS.

A reader made for this ignores the participant's own writers: DDS does not match the two, so that
no sample arrives twice. What DDS would have told of the match is told from here.
"""

from __future__ import annotations

from typing import Any

from rclpy_cyclone.dds import qos
from rclpy_cyclone.dds.events import POLICY_IDS


class _Topic:
    """The endpoints of one topic and type."""

    def __init__(self) -> None:
        self.publishers: list[Any] = []
        self.subscriptions: list[Any] = []

    def connect(self, pub: Any, sub: Any) -> None:
        """Judge a new pair."""
        if not sub._intra:
            return  # DDS does it
        refused = qos.refusal(pub._policies, sub._policies)
        if refused is None:
            pub._local = (*pub._local, sub)
            sub._local_publishers += 1
            _tell(pub, "publication_matched", 1)
            _tell(sub, "subscription_matched", 1)
            return
        policy = POLICY_IDS[refused]
        _tell(pub, "offered_incompatible_qos", 1, policy)
        _tell(sub, "requested_incompatible_qos", 1, policy)

    def disconnect(self, pub: Any, sub: Any) -> None:
        """Part a pair that may have been connected."""
        if sub in pub._local:
            pub._local = tuple(s for s in pub._local if s is not sub)
            sub._local_publishers -= 1
            _tell(pub, "publication_matched", -1)
            _tell(sub, "subscription_matched", -1)


def _tell(endpoint: Any, status: str, change: int, policy: int = 0) -> None:
    source = getattr(endpoint, "_event_source", None)
    if source is not None and not endpoint._destroyed:
        source.note(status, change, policy)


def _topic(participant: Any, endpoint: Any) -> _Topic:
    key = (endpoint._dds_topic, endpoint.msg_type._ros_name)
    found: _Topic = participant.local_topics.setdefault(key, _Topic())
    return found


def add_publisher(participant: Any, pub: Any) -> None:
    """Let a publisher serve the subscriptions of its participant."""
    with participant.lock:
        topic = _topic(participant, pub)
        topic.publishers.append(pub)
        for sub in topic.subscriptions:
            topic.connect(pub, sub)


def add_subscription(participant: Any, sub: Any) -> None:
    """Let a subscription be served; it gets what transient local publishers have kept."""
    with participant.lock:
        topic = _topic(participant, sub)
        topic.subscriptions.append(sub)
        for pub in topic.publishers:
            topic.connect(pub, sub)
            if sub._policies.transient_local and sub in pub._local:
                pub._serve_history(sub)


def remove_publisher(participant: Any, pub: Any) -> None:
    """Forget a publisher."""
    with participant.lock:
        topic = _topic(participant, pub)
        topic.publishers.remove(pub)
        for sub in topic.subscriptions:
            topic.disconnect(pub, sub)


def remove_subscription(participant: Any, sub: Any) -> None:
    """Forget a subscription."""
    with participant.lock:
        topic = _topic(participant, sub)
        topic.subscriptions.remove(sub)
        for pub in topic.publishers:
            topic.disconnect(pub, sub)
