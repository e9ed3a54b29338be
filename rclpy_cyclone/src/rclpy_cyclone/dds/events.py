"""Status changes of readers and writers.

A reader or writer can be attached to a wait set only once, however many events are listened to,
so that the listeners share a :class:`Source`.
"""

from __future__ import annotations

import ctypes as ct
from collections.abc import Callable
from typing import Any

from rclpy_cyclone.dds.clib import Status, blocking, check, quick


class Source:
    """The events of one reader or writer.

    :param entity: the reader or writer.
    """

    def __init__(self, entity: int) -> None:
        self.entity = entity
        self.mask = 0
        self.listeners: dict[int, Callable[[], None]] = {}  # status bit -> whom to tell

    def add(self, bit: int) -> None:
        """Have a status trigger the wait set."""
        self.mask |= bit
        check(blocking.dds_set_status_mask(self.entity, self.mask), "set status mask")

    def look(self) -> None:
        """Tell the listeners whose status has changed."""
        changes = ct.c_uint32()
        if quick.dds_get_status_changes(self.entity, ct.byref(changes)) < 0:
            return
        for bit, tell in list(self.listeners.items()):
            if changes.value & bit:
                tell()

    def status(self, name: str) -> Any:
        """Return a status structure, and so reset what triggered."""
        found = getattr(Status, f"{name}_status")()
        call = getattr(blocking, f"dds_get_{name}_status")
        check(call(self.entity, ct.byref(found)), f"get {name} status")
        return found


def source(endpoint: Any, side: str) -> Source:
    """Return the source of a publisher's (``'pub'``) or subscription's (``'sub'``) events."""
    if not hasattr(endpoint, "_event_source"):
        endpoint._event_source = Source(endpoint._writer if side == "pub" else endpoint._reader)
    return endpoint._event_source
