"""Futures, and the tasks an executor runs."""

from __future__ import annotations

import inspect
import sys
import threading
import warnings
import weakref
from collections.abc import Callable, Generator
from typing import Any


class Future:
    """The outcome of something that may not have happened yet.

    :param executor: runs the done callbacks; without one they are called at once.
    """

    def __init__(self, *, executor: Any = None) -> None:
        self._done = False
        self._cancelled = False
        self._result: Any = None
        self._exception: BaseException | None = None
        self._exception_fetched = False
        self._callbacks: list[Callable[[Any], Any]] = []
        self._waiters: list[Task] = []
        self._lock = threading.Lock()
        self._executor: Any = None
        self._set_executor(executor)

    def __del__(self) -> None:
        if self._exception is not None and not self._exception_fetched:
            print(
                f"The following exception was never retrieved: {self._exception}", file=sys.stderr
            )

    def __await__(self) -> Generator[Any, None, Any]:
        while not self._done:
            yield self
        return self.result()

    def cancel(self) -> None:
        """Mark the future cancelled, if it is not done."""
        with self._lock:
            if not self._done:
                self._cancelled = True
        self._finish()

    def cancelled(self) -> bool:
        """Say whether the future was cancelled."""
        return self._cancelled

    def done(self) -> bool:
        """Say whether there is a result or an exception."""
        return self._done

    def result(self) -> Any:
        """Return the result, ``None`` if there is none yet.

        :raises Exception: the one that was set.
        """
        if self._exception:
            raise self.exception()  # type: ignore[misc]
        return self._result

    def exception(self) -> BaseException | None:
        """Return the exception, ``None`` if there is none."""
        self._exception_fetched = True
        return self._exception

    def set_result(self, result: Any) -> None:
        """Give the future its result."""
        with self._lock:
            self._result = result
            self._done = True
            self._cancelled = False
        self._finish()

    def set_exception(self, exception: BaseException) -> None:
        """Give the future an exception instead of a result."""
        with self._lock:
            self._exception = exception
            self._exception_fetched = False
            self._done = True
            self._cancelled = False
        self._finish()

    def _finish(self) -> None:
        with self._lock:
            executor = self._executor() if self._executor else None
            callbacks, self._callbacks = self._callbacks, []
            waiters, self._waiters = self._waiters, []
        for task in waiters:
            task._resume()
        for callback in callbacks:
            if executor is not None:
                executor.create_task(callback, self)
                continue
            try:
                callback(self)
            except Exception as error:  # there may be more callbacks to call
                warnings.warn(f"Unhandled exception in done callback: {error}", stacklevel=2)

    def _set_executor(self, executor: Any) -> None:
        with self._lock:
            self._executor = None if executor is None else weakref.ref(executor)

    def add_done_callback(self, callback: Callable[[Any], Any]) -> None:
        """Have a function called with the future when it is done; at once if it is."""
        with self._lock:
            if not self._done:
                self._callbacks.append(callback)
                return
            executor = self._executor() if self._executor else None
        if executor is not None:
            executor.create_task(callback, self)
        else:
            callback(self)

    def _wait(self, task: Task) -> bool:
        """Have a task resumed when done; ``False`` if that is now."""
        with self._lock:
            if self._done:
                return False
            self._waiters.append(task)
            return True


class Task(Future):
    """A function or coroutine in the hands of an executor, which alone makes tasks."""

    _is_task = True

    def __init__(
        self,
        handler: Any,
        args: Any = None,
        kwargs: Any = None,
        executor: Any = None,
        ended: Callable[[], None] | None = None,
    ) -> None:
        super().__init__(executor=executor)
        self._args = args or ()
        self._kwargs = kwargs or {}
        self._handler = handler
        if inspect.iscoroutinefunction(handler):
            self._handler = handler(*self._args, **self._kwargs)
        self._ended = ended  # called once the handler has run to its end
        self._executing = False
        self._task_lock = threading.Lock()

    def __call__(self) -> None:
        """Run the function, or the coroutine up to where it has to wait."""
        if self._done or self._executing or not self._task_lock.acquire(blocking=False):
            return
        try:
            if self._done:
                return
            self._executing = True
            if inspect.iscoroutine(self._handler):
                self._step()
            else:
                try:
                    self.set_result(self._handler(*self._args, **self._kwargs))
                except Exception as error:
                    self.set_exception(error)
                self._complete()
            self._executing = False
        finally:
            self._task_lock.release()

    def _step(self) -> None:
        try:
            awaited = self._handler.send(None)
        except StopIteration as end:
            self._handler.close()
            self.set_result(end.value)
            self._complete()
        except Exception as error:
            self.set_exception(error)
            self._complete()
        else:
            executor = self._executor() if self._executor else None
            if isinstance(awaited, Future):
                if not awaited._wait(self):
                    self._resume()
            elif executor is not None:  # something else to poll until it lets go
                executor._poll(self)

    def _resume(self) -> None:
        executor = self._executor() if self._executor else None
        if executor is not None:
            executor._make_ready(self)

    def _complete(self) -> None:
        self._handler = None
        self._args = ()
        self._kwargs = {}
        ended, self._ended = self._ended, None
        if ended is not None:
            ended()

    def executing(self) -> bool:
        """Say whether the task is running now."""
        return self._executing

    def cancel(self) -> None:
        """Mark the task cancelled, if it is not done."""
        super().cancel()
