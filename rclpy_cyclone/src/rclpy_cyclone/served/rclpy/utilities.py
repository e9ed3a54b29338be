"""Global helpers: default context, command line, time outs."""

from __future__ import annotations

import sys
import threading
from collections.abc import Sequence

from rclpy._rclpy_pybind11 import RCLError, UnknownROSArgsError
from rclpy.constants import S_TO_NS
from rclpy.context import Context
from rclpy_cyclone import arguments

g_default_context: Context | None = None
g_context_lock = threading.Lock()


def get_default_context(*, shutting_down: bool = False) -> Context:
    """Return the default context.

    :param shutting_down: whether the next call shall give a new one.
    """
    global g_default_context
    with g_context_lock:
        if g_default_context is None:
            g_default_context = Context()
        found: Context = g_default_context
        if shutting_down:
            g_default_context = None
        return found


def remove_ros_args(args: Sequence[str] | None = None) -> list[str]:
    """Return a command line (``sys.argv`` by default) without what is ROS's.

    :raises UnknownROSArgsError: if there are ROS arguments nobody knows.
    :raises RCLError: if ROS arguments are malformed.
    """
    try:
        return arguments.parse(list(sys.argv if args is None else args)).others
    except arguments.UnknownArguments as error:
        raise UnknownROSArgsError(str(error)) from None
    except ValueError as error:
        raise RCLError(f"failed to parse arguments: {error}") from None


def ok(*, context: Context | None = None) -> bool:
    """Say whether a context (the default one) is initialised and not shut down."""
    used = get_default_context() if context is None else context
    return used.ok()


def shutdown(*, context: Context | None = None) -> None:
    """Shut down a context (the default one)."""
    if context is None:
        context = get_default_context(shutting_down=True)
    context.shutdown()


def try_shutdown(*, context: Context | None = None) -> None:
    """Shut down a context (the default one) unless that has been done."""
    global g_default_context
    if context is not None:
        context.try_shutdown()
        return
    with g_context_lock:
        old = g_default_context
    if old is not None:
        old.try_shutdown()
        with g_context_lock:
            if g_default_context is old and not Context.ok(old):
                g_default_context = None


def get_rmw_implementation_identifier() -> str:
    """Return the name of the middleware, as whose kind this one appears on the wire."""
    return "rmw_cyclonedds_cpp"


def get_available_rmw_implementations() -> set[str]:
    """Return the names of the available middlewares."""
    return {get_rmw_implementation_identifier()}


def timeout_sec_to_nsec(timeout_sec: float | None) -> int:
    """Return a time out in nanoseconds, -1 (for ever) for ``None`` or a negative one."""
    if timeout_sec is None or timeout_sec < 0:
        return -1
    return int(float(timeout_sec) * S_TO_NS)
