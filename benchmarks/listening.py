"""A node beside the graph that a benchmark runs: callbacks for topics, spun in a thread."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any


class Listening:
    """Hears topics until it is closed; use as a context manager."""

    def __init__(self, name: str = "benchmark") -> None:
        import rclpy
        from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
        from rclpy.node import Node

        rclpy.init(args=[])
        self.node: Any = Node(name)
        executor = SingleThreadedExecutor()
        executor.add_node(self.node)

        def spin() -> None:
            try:
                while rclpy.ok():
                    executor.spin_once(timeout_sec=0.2)
            except ExternalShutdownException:
                pass

        self._thread = threading.Thread(target=spin, daemon=True)
        self._spin = self._thread.start
        self._begun = False

    def hear(self, kind: type, topic: str, call: Callable[[Any], None], **options: Any) -> None:
        """Have a callback called, in another thread; to be said before `begin`."""
        self.node.create_subscription(kind, topic, call, options.pop("qos", 1000), **options)

    def begin(self) -> None:
        """Start to listen."""
        self._begun = True
        self._spin()

    def close(self) -> None:
        """Stop listening."""
        import rclpy

        rclpy.try_shutdown()
        if self._begun:
            self._thread.join(2.0)

    def __enter__(self) -> Listening:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
