"""Status changes of readers and writers.

A reader or writer can be attached to a wait set only once, however many events are listened to,
so that the listeners share a :class:`Source`.
"""

from __future__ import annotations

import ctypes as ct
from collections.abc import Callable
from typing import Any

from rclpy_cyclone.dds.clib import (
    OFFERED_INCOMPATIBLE_QOS,
    PUBLICATION_MATCHED,
    REQUESTED_INCOMPATIBLE_QOS,
    SUBSCRIPTION_MATCHED,
    Status,
    blocking,
    check,
    quick,
)

# DDS numbers of the policies for which endpoints may not match
POLICY_IDS = {"DURABILITY": 2, "DEADLINE": 4, "LIVELINESS": 8, "RELIABILITY": 11}
_BITS = {
    "publication_matched": PUBLICATION_MATCHED,
    "subscription_matched": SUBSCRIPTION_MATCHED,
    "offered_incompatible_qos": OFFERED_INCOMPATIBLE_QOS,
    "requested_incompatible_qos": REQUESTED_INCOMPATIBLE_QOS,
}


class Source:
    """The events of one reader or writer.

    :param entity: the reader or writer.
    """

    def __init__(self, entity: int) -> None:
        self.entity = entity
        self.mask = 0
        self.listeners: dict[int, Callable[[], None]] = {}  # status bit -> whom to tell
        # Status name -> what happened within the process: total, its change, current, its change
        self.local: dict[str, list[int]] = {}

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

    def note(self, name: str, change: int, policy: int) -> None:
        """Take note of a match (or its end), or a refusal, within the process."""
        counts = self.local.setdefault(name, [0, 0, 0, 0, 0])
        if change > 0:
            counts[0] += change
            counts[1] += change
        counts[2] += change
        counts[3] += change
        counts[4] = policy
        tell = self.listeners.get(_BITS[name])
        if tell is not None:
            tell()

    def status(self, name: str) -> Any:
        """Return a status structure, and so reset what triggered."""
        found = getattr(Status, f"{name}_status")()
        call = getattr(blocking, f"dds_get_{name}_status")
        check(call(self.entity, ct.byref(found)), f"get {name} status")
        counts = self.local.get(name)
        if counts is not None:
            found.total_count += counts[0]
            found.total_count_change += counts[1]
            if hasattr(found, "current_count"):
                found.current_count += counts[2]
                found.current_count_change += counts[3]
            elif counts[1]:
                found.last_policy_id = counts[4]
            counts[1] = counts[3] = 0
        return found


def source(endpoint: Any, side: str) -> Source:
    """Return the source of a publisher's (``'pub'``) or subscription's (``'sub'``) events."""
    if not hasattr(endpoint, "_event_source"):
        endpoint._event_source = Source(endpoint._writer if side == "pub" else endpoint._reader)
    return endpoint._event_source
