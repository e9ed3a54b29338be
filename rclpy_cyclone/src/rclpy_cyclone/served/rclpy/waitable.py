"""Other things an executor runs."""

from __future__ import annotations

from typing import Any

from rclpy._ready import Ready


class Waitable(Ready):
    """Base of what else the executor runs.

    rclpy's own interface for waitables works on its compiled wait set, which is not offered:
    only rclpy_cyclone's own waitables work.
    """

    def __init__(self, callback_group: Any) -> None:
        super().__init__()
        self.callback_group = callback_group
        callback_group.add_entity(self)
        if type(self)._take is Ready._take:
            raise NotImplementedError("custom waitables are not offered by rclpy_cyclone")
