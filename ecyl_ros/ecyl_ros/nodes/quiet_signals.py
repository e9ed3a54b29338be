"""Let SIGINT and SIGTERM end the spinning, not whatever line happens to run."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def quiet_signals() -> Iterator[None]:
    """Within, neither signal raises KeyboardInterrupt: to be entered before `rclpy.init`.

    rclpy's own handlers shut the context down, upon which `spin` returns or raises
    ExternalShutdownException between two callbacks. Python's would raise anywhere, in the middle
    of writing a message too, and leave a damaged recording.
    """
    numbers = (signal.SIGINT, signal.SIGTERM)
    before = [signal.signal(number, lambda *_: None) for number in numbers]
    try:
        yield
    finally:
        for number, handler in zip(numbers, before, strict=True):
            signal.signal(number, handler)
