"""The context: what lies between initialisation and shutdown."""

from __future__ import annotations

import sys
import threading
import weakref
from collections.abc import Callable
from inspect import ismethod
from types import TracebackType
from typing import Any

from rclpy._rclpy_pybind11 import RCLError, UnknownROSArgsError
from rclpy.impl.logging_severity import LoggingSeverity
from rclpy_cyclone import arguments, console

_contexts: weakref.WeakSet[Context] = weakref.WeakSet()  # those a signal shuts down


class Context:
    """Life time of a set of nodes, from :meth:`init` to :meth:`shutdown`; not to be reused.

    As a context manager it initialises itself and shuts itself down.
    """

    def __init__(self) -> None:
        self._lock = threading.RLock()
        self._callbacks: list[Any] = []
        self._wakers: list[Any] = []  # weak methods that wake whoever waits
        self._state = "new"  # then "valid", then "down"
        self._domain_id = 0
        self._arguments = arguments.Arguments()
        self._participant: Any = None
        self._nodes = 0

    @property
    def handle(self) -> Context | None:
        """The context itself once it is initialised; there is no compiled part."""
        return None if self._state == "new" else self

    def init(
        self,
        args: list[str] | None = None,
        *,
        initialize_logging: bool = True,
        domain_id: int | None = None,
    ) -> None:
        """Initialise.

        :param args: command line, ``sys.argv`` if it is not given.
        :param initialize_logging: whether to apply the command line's log levels.
        :param domain_id: DDS domain, that of ``ROS_DOMAIN_ID`` if it is not given.
        :raises RuntimeError: if it was initialised before, or the domain is negative.
        :raises RCLError: if ROS arguments or environment variables are malformed.
        :raises UnknownROSArgsError: if there are ROS arguments nobody knows.
        """
        from rclpy_cyclone.dds import domain

        with self._lock:
            if domain_id is not None and domain_id < 0:
                raise RuntimeError(f"Domain id ({domain_id}) should not be lower than zero.")
            if self._state != "new":
                raise RuntimeError("Context.init() must only be called once")
            try:
                self._arguments = arguments.parse(list(sys.argv if args is None else args))
            except arguments.UnknownArguments as error:
                raise UnknownROSArgsError(str(error)) from None
            except ValueError as error:
                raise RCLError(f"failed to initialize rcl: {error}") from None
            try:
                self._domain_id = domain.domain_id() if domain_id is None else domain_id
                domain.discovery_range()
            except ValueError as error:
                raise RCLError(f"failed to initialize rcl: {error}") from None
            self._state = "valid"
            _contexts.add(self)
        if initialize_logging:
            console.enabled = self._arguments.stdout
            for name, level in self._arguments.log_levels.items():
                console.set_level(name, LoggingSeverity[level.upper()])

    def ok(self) -> bool:
        """Say whether the context is initialised and not shut down."""
        return self._state == "valid"

    def shutdown(self) -> None:
        """Shut down.

        :raises RuntimeError: if the context was never initialised, or is shut down already.
        """
        if self._state == "new":
            raise RuntimeError("Context must be initialized before it can be shutdown")
        if not self._shut_down():
            raise RCLError("failed to shutdown: rcl_shutdown already called on the given context")

    def try_shutdown(self) -> None:
        """Shut down, if the context is valid."""
        if self._state == "valid":
            self._shut_down()

    def _shut_down(self) -> bool:
        with self._lock:
            was_valid = self._state == "valid"
            self._state = "down"
            callbacks, self._callbacks = self._callbacks, []
        _call(callbacks)
        _call(self._wakers)
        if was_valid and self._nodes == 0:
            self._close()
        return was_valid

    def _invalidate(self) -> None:
        """Become invalid because of a signal: wake all waiters, but call no callbacks.

        (rclpy's signal handlers do not know of the callbacks given to :meth:`on_shutdown`.)
        """
        if self._state == "valid":
            self._state = "down"
            _call(self._wakers)

    def _on_invalid(self, method: Callable[[], None]) -> None:
        """Have a bound method, held weakly, called when the context becomes invalid."""
        with self._lock:
            self._wakers = [w for w in self._wakers if w() is not None]
            self._wakers.append(weakref.WeakMethod(method))

    def on_shutdown(self, callback: Callable[[], None]) -> None:
        """Have a function called on shutdown; at once if that has been.

        Bound methods are held weakly.

        :raises TypeError: if it cannot be called.
        """
        if not callable(callback):
            raise TypeError("callback should be a callable, got {}", type(callback))
        with self._lock:
            if self._state != "down":
                entry = weakref.WeakMethod(callback) if ismethod(callback) else callback
                self._callbacks.append(entry)
                return
        callback()

    def get_domain_id(self) -> int:
        """Return the number of the DDS domain.

        :raises RuntimeError: if the context was never initialised.
        """
        if self._state == "new":
            raise RuntimeError("Context must be initialized before it can have a domain id")
        return self._domain_id

    def destroy(self) -> None:
        """Leave the DDS domain."""
        self._close()

    def _join(self) -> Any:
        """Return the DDS participant, made on first use."""
        with self._lock:
            if self._participant is None:
                from rclpy_cyclone.dds.participant import Participant

                self._participant = Participant(self._domain_id, self._arguments.enclave)
            return self._participant

    def _node_gone(self) -> None:
        with self._lock:
            self._nodes -= 1
            last = self._nodes == 0 and self._state == "down"
        if last:
            self._close()

    def _close(self) -> None:
        with self._lock:
            participant, self._participant = self._participant, None
        if participant is not None:
            participant.close()

    def __enter__(self) -> Context:
        # rclpy.init() returns a context that is initialised already.
        if self._state == "new":
            self.init()
        return self

    def __exit__(
        self,
        exc_type: type[BaseException] | None,
        exc_val: BaseException | None,
        exc_tb: TracebackType | None,
    ) -> None:
        self.try_shutdown()


def _call(entries: list[Any]) -> None:
    for entry in list(entries):
        callback = entry() if isinstance(entry, weakref.WeakMethod) else entry
        if callback is not None:
            callback()
