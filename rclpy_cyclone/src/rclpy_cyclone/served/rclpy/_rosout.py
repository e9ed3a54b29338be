"""Log messages of a node on ``/rosout``."""

from __future__ import annotations

from typing import Any

from rclpy.qos import _qos_profile_rosout
from rclpy_cyclone import console


def open_for(node: Any) -> None:
    """Let a node's log messages go to ``/rosout``."""
    from rcl_interfaces.msg import Log

    publisher = node.create_publisher(Log, "/rosout", _qos_profile_rosout)
    node._publishers.remove(publisher)  # it is not among the node's own publishers
    for handler in publisher.event_handlers:
        node.remove_waitable(handler)
    node._rosout = publisher

    def sink(
        stamp: int, level: int, name: str, text: str, function: str, file: str, line: int
    ) -> None:
        if publisher._destroyed or node._participant.closed:
            return
        message = Log(level=level, name=name, msg=text, file=file, function=function, line=line)
        message.stamp.sec, message.stamp.nanosec = divmod(stamp, 1_000_000_000)
        publisher.publish(message)

    node._rosout_sink = sink
    console.sinks[node._logger.name] = sink


def close_for(node: Any) -> None:
    """Undo :func:`open_for`."""
    publisher = getattr(node, "_rosout", None)
    if publisher is None:
        return
    if console.sinks.get(node._logger.name) is node._rosout_sink:
        del console.sinks[node._logger.name]
    publisher.destroy()
