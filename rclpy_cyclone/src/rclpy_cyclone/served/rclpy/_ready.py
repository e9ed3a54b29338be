"""What the executor runs: the common part of subscriptions, timers, services and so on."""

from __future__ import annotations

from typing import Any


class Ready:
    """Something with callbacks, which asks the executor to be run when it has work.

    Subclasses say with :meth:`_pending` whether there is work, and give out one callback at a
    time with :meth:`_take`.
    """

    callback_group: Any = None
    _is_task = False

    def __init__(self) -> None:
        self._executor: Any = None  # set while the node is in an executor
        self._queued = False  # whether it stands in the executor's queue
        self._destroyed = False
        # Entities of DDS to wait for: (entity, what to call when it triggers).
        self._waits: list[tuple[int, Any]] = []

    def _ready(self) -> None:
        """Ask to be run. May be called from any thread."""
        executor = self._executor
        if executor is not None and not self._queued:
            self._queued = True
            executor._make_ready(self)

    def _pending(self) -> bool:
        """Say whether there is work."""
        return False

    def _take(self) -> tuple[Any, tuple[Any, ...]] | None:
        """Return one callback with its arguments, ``None`` if there is none after all."""
        raise NotImplementedError

    def _attach(self, executor: Any) -> None:
        """Come under an executor."""
        self._executor = executor
        self._queued = False
        for entity, react in self._waits:
            executor._watch(entity, react)
        if self._pending():
            self._ready()

    def _detach(self) -> None:
        """Leave the executor."""
        executor, self._executor = self._executor, None
        if executor is not None:
            for entity, _ in self._waits:
                executor._unwatch(entity)
        self._queued = False

    @property
    def handle(self) -> Any:
        """The entity itself; there is no compiled part."""
        return self

    def __enter__(self) -> Any:
        return self

    def __exit__(self, *exc: Any) -> None:
        return None

    def destroy(self) -> None:
        """Release what the entity holds. Nodes offer ``destroy_...`` for this."""
        self._destroyed = True
        self._detach()
