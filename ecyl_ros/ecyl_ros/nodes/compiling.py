"""Say why a node starts late: on a new machine the drive's equations are compiled first."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager

from rclpy.node import Node

SLOW_S = 2.0  # from the cache it takes a fraction of this


@contextmanager
def compiling(node: Node) -> Iterator[None]:
    """Log one line if what is done within takes long enough for somebody to wonder."""
    said = threading.Timer(
        SLOW_S,
        node.get_logger().info,
        ["compiling the drive's equations, up to a minute on the first start (cached afterwards)"],
    )
    said.daemon = True
    said.start()
    try:
        yield
    finally:
        said.cancel()
