"""Waiting for a single message."""

from __future__ import annotations

import time
from typing import Any

from rclpy.qos import QoSProfile


def wait_for_message(
    msg_type: Any,
    node: Any,
    topic: str,
    *,
    qos_profile: QoSProfile | int = 1,
    time_to_wait: float = -1,
) -> tuple[bool, Any]:
    """Wait for the next message of a topic.

    :param msg_type: class of the message.
    :param node: node to subscribe with; it need not spin.
    :param topic: name of the topic.
    :param qos_profile: profile of the subscription, or its depth.
    :param time_to_wait: how long to wait in seconds; for ever if negative.
    :return: whether one came, and the message or ``None``.
    """
    from rclpy.executors import SingleThreadedExecutor

    found: list[Any] = []
    end = None if time_to_wait < 0 else time.monotonic() + time_to_wait
    # A node of its own executor would be taken from the one it may be in.
    executor = SingleThreadedExecutor(context=node.context)
    sub = node.create_subscription(msg_type, topic, found.append, qos_profile)
    if node.executor is not None:
        sub._detach()
    sub._attach(executor)
    try:
        while node.context.ok() and not found:
            left = None if end is None else end - time.monotonic()
            if left is not None and left <= 0:
                break
            executor.spin_once(left)
    finally:
        sub._detach()
        node.destroy_subscription(sub)
        executor.shutdown()
    return (True, found[0]) if found else (False, None)
