"""A wait set: sleep until one of several entities of DDS triggers, or somebody wakes us."""

from __future__ import annotations

import ctypes as ct
from typing import Any

from rclpy_cyclone.dds.clib import blocking, check, quick

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

    def wait(self, timeout_ns: int) -> list[int]:
        """Return the entities that have triggered, waiting for one if there is none.

        :param timeout_ns: how long to wait; 0 only looks.
        """
        library = blocking if timeout_ns else quick
        count = library.dds_waitset_wait(self._set, self._pointer, _MOST, timeout_ns)
        if count <= 0:
            # The participant may be gone, which every waiter learns this way.
            return []
        found = self._found[: min(count, _MOST)]
        if self._guard in found:
            quick.dds_take_guardcondition(self._guard, ct.byref(self._flag))
        return found
