"""What all executors share: the queue of ready items, and waiting for more.

Items are put into the queue by whoever makes them ready: a publisher of this process, DDS through
the wait set, a timer that is due, another thread. The executor looks at DDS and at the timers when
the queue is empty, and now and then while it is not.
"""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from types import TracebackType
from typing import Any

from rclpy.context import Context
from rclpy.task import Future, Task
from rclpy.utilities import get_default_context
from rclpy_cyclone.dds import clib, spinning, waiting

_now = time.monotonic_ns
_LOOK_NS = 200_000  # how long items may be run without a look at DDS
_NEVER = 1 << 62
_RECENT_NS = 1_000_000  # DDS is active if it had something so recently


class TimeoutException(Exception):
    """The time out has come."""


class ShutdownException(Exception):
    """The executor was shut down."""


class ExternalShutdownException(Exception):
    """The context was shut down."""


class ConditionReachedException(Exception):
    """The future waited for is done."""


class TimeoutObject:
    """A time out that may be changed while it is used."""

    def __init__(self, timeout: float) -> None:
        self.timeout = timeout


class Executor:
    """Base of the executors. As a context manager it is shut down on leaving.

    :param context: the context, by default the default one.
    """

    def __init__(self, *, context: Context | None = None) -> None:
        super().__init__()
        self._context = get_default_context() if context is None else context
        self._nodes: set[Any] = set()
        self._nodes_lock = threading.RLock()
        self._is_shutdown = False
        self._queue: deque[Any] = deque()
        self._polled: list[Task] = []  # coroutines that wait for something we cannot see
        self._timers: list[Any] = []
        self._next_timer = _NEVER  # when a timer is due, by the monotonic clock
        self._next_look = 0
        self._wait: waiting.WaitSet | None = None
        self._watched: dict[int, Callable[[], None]] = {}
        self._watchers: dict[int, int] = {}  # how many asked for each of them
        self._waiting = False
        self._last_found = 0  # when DDS last had something
        self._context._on_invalid(self.wake)

    @property
    def context(self) -> Context:
        """The context."""
        return self._context

    # What other threads may call ----------------------------------------------------------

    def wake(self) -> None:
        """Make the executor look again at what there is to do."""
        if self._waiting and self._wait is not None:
            self._wait.wake()

    def _make_ready(self, item: Any) -> None:
        self._queue.append(item)
        if self._waiting and self._wait is not None:
            self._wait.wake()

    def _poll(self, task: Task) -> None:
        self._polled.append(task)

    def _timers_changed(self) -> None:
        self._next_timer = 0
        self.wake()

    def create_task(self, callback: Any, *args: Any, **kwargs: Any) -> Task:
        """Have a function or coroutine run by the executor.

        :param callback: function, coroutine function or coroutine; the arguments are for it.
        :return: the task, which is a future of the result.
        """
        task = Task(callback, args, kwargs, executor=self)
        self._make_ready(task)
        return task

    # Nodes --------------------------------------------------------------------------------

    def add_node(self, node: Any) -> bool:
        """Take a node in, whose callbacks are run from then on.

        :return: ``False`` if it was in already.
        """
        with self._nodes_lock:
            if node in self._nodes:
                return False
            self._nodes.add(node)
            node.executor = self
            for entity in node._entities():
                entity._attach(self)
            self.wake()
            return True

    def remove_node(self, node: Any) -> None:
        """Let a node go."""
        with self._nodes_lock:
            if node not in self._nodes:
                return
            self._nodes.remove(node)
            for entity in node._entities():
                entity._detach()
            self.wake()

    def get_nodes(self) -> list[Any]:
        """Return the nodes."""
        with self._nodes_lock:
            return list(self._nodes)

    def _watch(self, entity: int, react: Callable[[], None]) -> None:
        """Have a function called when an entity of DDS triggers."""
        with self._nodes_lock:
            self._watched[entity] = react
            self._watchers[entity] = self._watchers.get(entity, 0) + 1
            if self._wait is not None and self._watchers[entity] == 1:
                self._wait.attach(entity)

    def _unwatch(self, entity: int) -> None:
        with self._nodes_lock:
            self._watchers[entity] = self._watchers.get(entity, 0) - 1
            if self._watchers[entity] > 0:
                return
            del self._watchers[entity]
            if self._watched.pop(entity, None) is not None and self._wait is not None:
                self._wait.detach(entity)

    # Waiting ------------------------------------------------------------------------------

    def _next(self, timeout: float | None, condition: Callable[[], bool] | None = None) -> Any:
        """Return the next item to run.

        :raises TimeoutException: if there is none in time.
        :raises ShutdownException: if the executor was shut down.
        :raises ExternalShutdownException: if the context was shut down.
        :raises ConditionReachedException: if the condition holds.
        """
        end = -1 if timeout is None or timeout < 0 else _now() + int(timeout * 1e9)
        queue = self._queue
        looked = False
        if self._polled:
            polled, self._polled = self._polled, []
            queue.extend(t for t in polled if not t._done)
        while True:
            if self._is_shutdown:
                raise ShutdownException()
            if self._context._state != "valid":
                raise ExternalShutdownException()
            if condition is not None and condition():
                raise ConditionReachedException()
            now = _now()
            if now >= self._next_timer:
                self._check_timers()
            if queue:
                if now >= self._next_look:
                    self._look(0)
                while queue:
                    item = queue.popleft()
                    if item._is_task or item._executor is self:
                        return item
                continue
            if end >= 0 and now >= end and looked:
                raise TimeoutException()
            until = min(self._next_timer, end if end >= 0 else _NEVER)
            self._look(max(0, until - now) if until < _NEVER else clib.INFINITY)
            looked = True
            if queue and self._context._state == "valid" and not self._is_shutdown:
                item = queue.popleft()
                if item._is_task or item._executor is self:
                    return item
            if self._polled:
                polled, self._polled = self._polled, []
                queue.extend(t for t in polled if not t._done)

    def _look(self, timeout_ns: int) -> None:
        """See what DDS has, waiting for it if nothing else is there to do."""
        wait = self._wait
        if wait is None:
            wait = self._open()
        triggered: Sequence[int]
        if timeout_ns:
            self._waiting = True
            try:
                # Whoever made something ready before this flag was up did not wake us.
                if self._queue or self._next_timer == 0 or self._context._state != "valid":
                    timeout_ns = 0
                triggered = ()
                if spinning.SPIN_NS and timeout_ns:
                    now = _now()
                    if now - self._last_found < _RECENT_NS and spinning.allowed(now):
                        triggered = wait.spin(now + min(spinning.SPIN_NS, timeout_ns))
                if not triggered:
                    triggered = wait.wait(timeout_ns)
            finally:
                self._waiting = False
        else:
            triggered = wait.wait(0)
        now = _now()
        if triggered:
            self._last_found = now
            for entity in triggered:
                react = self._watched.get(entity)
                if react is not None:
                    react()
        self._next_look = now + _LOOK_NS

    def _open(self) -> waiting.WaitSet:
        with self._nodes_lock:
            self._wait = waiting.WaitSet(self._context._join())
            for entity in self._watched:
                self._wait.attach(entity)
            return self._wait

    def _check_timers(self) -> None:
        """Queue the timers that are due, and note when the next one is."""
        self._next_timer = _NEVER
        nearest = _NEVER
        now = _now()
        for timer in self._timers:
            if timer._canceled or timer._queued:
                continue
            left = timer._next - timer._clock._now()
            if left <= 0:
                timer._queued = True
                self._queue.append(timer)
            elif not timer._clock._simulated():  # simulated time tells us when it moves
                nearest = min(nearest, now + left)
        if self._next_timer == _NEVER:
            self._next_timer = nearest

    def _park(self, group: Any, item: Any) -> None:
        """Keep an item whose group is busy until the group is free."""
        item._queued = True
        group._parked.append((self, item))
        if group.can_execute(item):  # it became free in between
            group._unpark()

    def _end(self, group: Any, item: Any) -> None:
        group.ending_execution(item)
        group._unpark()

    # Spinning -----------------------------------------------------------------------------

    def spin(self) -> None:
        """Run callbacks until the executor or the context is shut down."""
        while self._context.ok() and not self._is_shutdown:
            self.spin_once()

    def spin_until_future_complete(self, future: Future, timeout_sec: float | None = None) -> None:
        """Run callbacks until a future is done, or a time out has come."""
        future.add_done_callback(lambda _: self.wake())
        end = None
        if timeout_sec is not None and timeout_sec >= 0:
            end = time.monotonic() + timeout_sec
        left = TimeoutObject(-1.0 if timeout_sec is None else timeout_sec)
        while self._context.ok() and not future.done() and not self._is_shutdown:
            self._spin_once_impl(left, future.done)
            if end is not None:
                left.timeout = end - time.monotonic()
                if left.timeout <= 0:
                    return

    def _spin_once_impl(
        self,
        timeout_sec: float | TimeoutObject | None = None,
        condition: Callable[[], bool] | None = None,
    ) -> None:
        self.spin_once(
            timeout_sec.timeout if isinstance(timeout_sec, TimeoutObject) else timeout_sec
        )

    def spin_once(self, timeout_sec: float | None = None) -> None:
        """Run one callback; executors define this."""
        raise NotImplementedError

    def spin_once_until_future_complete(
        self, future: Future, timeout_sec: float | TimeoutObject | None = None
    ) -> None:
        """Run one callback, or return because a future is done; executors define this."""
        raise NotImplementedError

    def shutdown(self, timeout_sec: float | None = None) -> bool:
        """Stop running callbacks.

        :param timeout_sec: how long to wait for those that run; for ever if ``None``.
        :return: whether none runs any more.
        """
        self._is_shutdown = True
        self.wake()
        for node in self.get_nodes():
            self.remove_node(node)
        return True

    def __enter__(self) -> Any:
        return self

    def __exit__(
        self,
        exc_type: type[BaseException] | None,
        exc_val: BaseException | None,
        exc_tb: TracebackType | None,
    ) -> None:
        self.shutdown()
