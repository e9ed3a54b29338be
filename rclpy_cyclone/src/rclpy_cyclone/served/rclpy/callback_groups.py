"""Which callbacks may run at the same time."""

from __future__ import annotations

import weakref
from collections import deque
from threading import Lock
from typing import Any


class CallbackGroup:
    """Base of the callback groups. Subclasses say when an entity's callback may run."""

    def __init__(self) -> None:
        super().__init__()
        self.entities: set[Any] = set()
        # Entities that were ready but had to wait, with the executor to tell.
        self._parked: deque[tuple[Any, Any]] = deque()

    def add_entity(self, entity: Any) -> None:
        """Add a subscription, timer, client, service, guard condition or waitable."""
        self.entities.add(weakref.ref(entity))

    def has_entity(self, entity: Any) -> bool:
        """Say whether an entity is in the group."""
        return weakref.ref(entity) in self.entities

    def can_execute(self, entity: Any) -> bool:
        """Say whether the entity's callback may start now."""
        raise NotImplementedError

    def beginning_execution(self, entity: Any) -> bool:
        """Ask to start; after ``True``, :meth:`ending_execution` must follow."""
        raise NotImplementedError

    def ending_execution(self, entity: Any) -> None:
        """Tell that a callback has ended."""
        raise NotImplementedError

    def _unpark(self) -> None:
        while self._parked:
            executor, entity = self._parked.popleft()
            executor._make_ready(entity)


class ReentrantCallbackGroup(CallbackGroup):
    """Lets callbacks run at the same time without restriction."""

    def can_execute(self, entity: Any) -> bool:
        """Return ``True``."""
        return True

    def beginning_execution(self, entity: Any) -> bool:
        """Return ``True``."""
        return True

    def ending_execution(self, entity: Any) -> None:
        """Do nothing."""


class MutuallyExclusiveCallbackGroup(CallbackGroup):
    """Lets one callback run at a time."""

    def __init__(self) -> None:
        super().__init__()
        self._lock = Lock()  # held while a callback runs

    def can_execute(self, entity: Any) -> bool:
        """Say whether no callback of the group runs now."""
        return not self._lock.locked()

    def beginning_execution(self, entity: Any) -> bool:
        """Ask to start a callback."""
        return self._lock.acquire(False)

    def ending_execution(self, entity: Any) -> None:
        """Tell that the callback has ended."""
        self._lock.release()
