"""Executors: who runs the callbacks, and in which threads."""

from __future__ import annotations

import inspect
import os
import time
import warnings
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from threading import Condition
from typing import Any

from rclpy._executor_base import (
    ConditionReachedException,
    Executor,
    ExternalShutdownException,
    ShutdownException,
    TimeoutException,
    TimeoutObject,
)
from rclpy.task import Future, Task


async def await_or_execute(callback: Callable[..., Any], *args: Any) -> Any:
    """Call a function, or await a coroutine function, and return the result."""
    if inspect.iscoroutinefunction(callback):
        return await callback(*args)
    return callback(*args)


def _is_coroutine_function(callback: Any) -> bool:
    try:  # the usual case, without inspect: this runs for every message
        return bool(callback.__code__.co_flags & inspect.CO_COROUTINE)
    except AttributeError:  # not a plain function or method
        return inspect.iscoroutinefunction(callback)


class SingleThreadedExecutor(Executor):
    """Runs callbacks in the thread that spins."""

    def __init__(self, *, context: Any = None) -> None:
        super().__init__(context=context)

    def _spin_once_impl(
        self,
        timeout_sec: float | TimeoutObject | None = None,
        condition: Callable[[], bool] | None = None,
    ) -> None:
        timeout = timeout_sec.timeout if isinstance(timeout_sec, TimeoutObject) else timeout_sec
        try:
            while True:
                item = self._next(timeout, condition)
                if self._run(item):
                    return
                if timeout is not None and timeout >= 0:
                    timeout = 0.0  # the time out has begun: only what is ready counts
        except (ShutdownException, TimeoutException, ConditionReachedException):
            pass

    def spin(self) -> None:
        """Run callbacks until the executor or the context is shut down.

        :raises ExternalShutdownException: if the context was shut down while waiting.
        """
        if type(self).spin_once is not SingleThreadedExecutor.spin_once:
            super().spin()  # a subclass has its own idea
            return
        following, run = self._next, self._run
        while self._context._state == "valid" and not self._is_shutdown:
            try:
                item = following(None)
            except ShutdownException:
                return
            run(item)

    def spin_until_future_complete(self, future: Future, timeout_sec: float | None = None) -> None:
        """Run callbacks until a future is done, or a time out has come."""
        plain = type(self).spin_once is SingleThreadedExecutor.spin_once
        if not plain or (timeout_sec is not None and timeout_sec >= 0):
            super().spin_until_future_complete(future, timeout_sec)
            return
        future.add_done_callback(lambda _: self.wake())
        following, run, done = self._next, self._run, future.done
        while self._context._state == "valid" and not self._is_shutdown and not future._done:
            try:
                item = following(None, done)
            except (ShutdownException, ConditionReachedException):
                return
            run(item)

    def spin_once(self, timeout_sec: float | None = None) -> None:
        """Run one callback, waiting for it if need be.

        :param timeout_sec: how long to wait; for ever if ``None`` or negative.
        :raises ExternalShutdownException: if the context is shut down.
        """
        self._spin_once_impl(timeout_sec)

    def spin_once_until_future_complete(
        self, future: Future, timeout_sec: float | TimeoutObject | None = None
    ) -> None:
        """Run one callback, or return because a future is done."""
        future.add_done_callback(lambda _: self.wake())
        self._spin_once_impl(timeout_sec, future.done)

    def _run(self, item: Any) -> bool:
        """Run one item of the queue; ``False`` if there was nothing to run after all."""
        if item._is_task:
            item()
            if item._exception is not None:
                raise item.exception()
            return True
        item._queued = False
        group = item.callback_group
        if not group.beginning_execution(item):
            self._park(group, item)
            return False
        ended = False
        try:
            call = item._take()
            if item._pending():
                item._ready()
            if call is None:
                return False
            callback, args = call
            if _is_coroutine_function(callback):
                ended = True
                task = Task(callback, args, None, self, lambda: self._end(group, item))
                task()
                if task._exception is not None:
                    raise task.exception()
            else:
                callback(*args)
            return True
        finally:
            if not ended:
                group.ending_execution(item)
                if group._parked:
                    group._unpark()


class _WorkTracker:
    """Counts the callbacks that are running."""

    def __init__(self) -> None:
        self._running = 0
        self._condition = Condition()

    def __enter__(self) -> None:
        with self._condition:
            self._running += 1

    def __exit__(self, *exc: Any) -> None:
        with self._condition:
            self._running -= 1
            self._condition.notify_all()

    def wait(self, timeout_sec: float | None = None) -> bool:
        """Wait until none is running; ``False`` on a time out."""
        if timeout_sec is not None and timeout_sec < 0:
            timeout_sec = None
        with self._condition:
            return self._condition.wait_for(lambda: self._running == 0, timeout_sec)


class MultiThreadedExecutor(Executor):
    """Runs callbacks in a pool of threads.

    :param num_threads: size of the pool, by default the number of usable processors.
    :param context: the context, by default the default one.
    """

    def __init__(self, num_threads: int | None = None, *, context: Any = None) -> None:
        super().__init__(context=context)
        if num_threads is None:
            affinity = getattr(os, "sched_getaffinity", None)
            num_threads = (len(affinity(0)) if affinity else os.cpu_count()) or 2
        if num_threads == 1:
            warnings.warn(
                "MultiThreadedExecutor is used with a single thread.\n"
                "Use the SingleThreadedExecutor instead.",
                stacklevel=2,
            )
        self._pool = ThreadPoolExecutor(num_threads)
        self._tracker = _WorkTracker()
        self._failures: list[BaseException] = []

    def _spin_once_impl(
        self,
        timeout_sec: float | TimeoutObject | None = None,
        condition: Callable[[], bool] | None = None,
    ) -> None:
        timeout = timeout_sec.timeout if isinstance(timeout_sec, TimeoutObject) else timeout_sec
        end = None if timeout is None or timeout < 0 else time.monotonic() + timeout
        try:
            while True:
                left = None if end is None else max(0.0, end - time.monotonic())
                item = self._next(left, lambda: bool(self._failures) or _holds(condition))
                if self._submit(item):
                    break
        except (
            ExternalShutdownException,
            ShutdownException,
            TimeoutException,
            ConditionReachedException,
        ):
            pass
        if self._failures:
            raise self._failures.pop(0)

    def spin_once(self, timeout_sec: float | None = None) -> None:
        """Start one callback in the pool, waiting for it to be due if need be.

        :param timeout_sec: how long to wait; for ever if ``None`` or negative.
        """
        self._spin_once_impl(timeout_sec)

    def spin_once_until_future_complete(
        self, future: Future, timeout_sec: float | TimeoutObject | None = None
    ) -> None:
        """Start one callback, or return because a future is done."""
        future.add_done_callback(lambda _: self.wake())
        self._spin_once_impl(timeout_sec, future.done)

    def _submit(self, item: Any) -> bool:
        if item._is_task:
            self._pool.submit(self._work, item)
            return True
        item._queued = False
        group = item.callback_group
        if not group.beginning_execution(item):
            self._park(group, item)
            return False
        call = item._take()
        if item._pending():
            item._ready()
        if call is None:
            self._end(group, item)
            return False
        callback, args = call
        task = Task(callback, args, None, self, lambda: self._end(group, item))
        self._pool.submit(self._work, task)
        return True

    def _work(self, task: Task) -> None:
        with self._tracker:
            task()
        if task._done and task._exception is not None:
            self._failures.append(task.exception())
            self.wake()

    def shutdown(self, timeout_sec: float | None = None) -> bool:
        """Stop; see :meth:`.Executor.shutdown`. The callbacks that run are waited for."""
        super().shutdown(timeout_sec)
        done = self._tracker.wait(timeout_sec)
        self._pool.shutdown(wait=False)
        return done


def _holds(condition: Callable[[], bool] | None) -> bool:
    return condition is not None and condition()
