"""A wait set: sleep until one of several entities of DDS triggers, or somebody wakes us."""

from __future__ import annotations

import ctypes as ct
import time
from collections.abc import Sequence
from typing import Any

from rclpy_cyclone.dds.clib import blocking, check, quick

_wait, _look = blocking.dds_waitset_wait, quick.dds_waitset_wait
_now = time.monotonic_ns
_MOST = 64  # triggers reported by one wait; the rest come with the next


class WaitSet:
    """Waits for read conditions, status changes, and :meth:`wake`.

    :param participant: the :class:`.Participant` whose entities can be waited for.
    """

    def __init__(self, participant: Any) -> None:
        self._participant = participant
        self._set = check(blocking.dds_create_waitset(participant.entity), "create wait set")
        self._guard = check(
            blocking.dds_create_guardcondition(participant.entity), "create guard condition"
        )
        self._found = (ct.c_ssize_t * _MOST)()
        self._pointer = ct.cast(self._found, ct.c_void_p)
        self._flag = ct.c_bool()
        self._flag_pointer = ct.byref(self._flag)
        self.attach(self._guard)

    def attach(self, entity: int) -> None:
        """Wait for an entity too; it is reported under its own handle."""
        check(quick.dds_waitset_attach(self._set, entity, entity), "attach to wait set")

    def detach(self, entity: int) -> None:
        """Wait for an entity no more."""
        quick.dds_waitset_detach(self._set, entity)

    def wake(self) -> None:
        """End a wait, the next one if there is none at present. May be called from any thread."""
        quick.dds_set_guardcondition(self._guard, True)

    def wait(self, timeout_ns: int) -> Sequence[int]:
        """Return the entities that have triggered, waiting for one if there is none.

        :param timeout_ns: how long to wait; 0 only looks.
        """
        if timeout_ns:
            count = _wait(self._set, self._pointer, _MOST, timeout_ns)
        else:
            count = _look(self._set, self._pointer, _MOST, 0)
        if count <= 0:
            # The participant may be gone, which every waiter learns this way.
            return ()
        if count == 1 and self._found[0] != self._guard:
            return (self._found[0],)
        found = self._found[: min(count, _MOST)]
        if self._guard in found:
            quick.dds_take_guardcondition(self._guard, self._flag_pointer)
        return found

    def spin(self, end_ns: int) -> Sequence[int]:
        """Look again and again for something that has triggered, until a time has come.

        :param end_ns: the time, by the monotonic clock.
        """
        wait_set, pointer = self._set, self._pointer
        while _look(wait_set, pointer, _MOST, 0) == 0:
            if _now() >= end_ns:
                return ()
        return self.wait(0)
