"""Shutdown on SIGINT and SIGTERM.

The interpreter's low-level handler writes each signal's number to a pipe, whatever the main
thread is doing; a thread of ours reads it, shuts the contexts down and so wakes the executors.
Handlers that are there stay in force: that of SIGINT raises KeyboardInterrupt in the main thread.
"""

from __future__ import annotations

import os
import signal
import threading
import warnings
from typing import Any

from rclpy import context as _context
from rclpy._rclpy_pybind11 import SignalHandlerOptions
from rclpy.guard_condition import GuardCondition

_lock = threading.Lock()
_current = SignalHandlerOptions.NO
_pipe: tuple[int, int] | None = None
_previous_fd = -1
_handlers: dict[int, Any] = {}  # signal -> Python handler in force while we listen
_replaced: dict[int, Any] = {}  # signal -> disposition that ours took the place of


def _quiet(number: int, frame: Any) -> None:
    """Keep a signal from ending the process, and from being ignored: the pipe has it."""


def install_signal_handlers(
    options: SignalHandlerOptions = SignalHandlerOptions.ALL,
) -> None:
    """Let signals shut down all contexts.

    :param options: which signals; ``NO`` leaves things as they are.
    """
    global _current, _pipe, _previous_fd
    if options == SignalHandlerOptions.NO:
        return
    with _lock:
        if threading.current_thread() is not threading.main_thread():
            warnings.warn(
                "signal handlers can only be installed from the main thread", stacklevel=3
            )
            return
        if _pipe is None:
            _pipe = os.pipe()
            os.set_blocking(_pipe[1], False)
            threading.Thread(target=_listen, args=(_pipe[0],), daemon=True).start()
        if _current == SignalHandlerOptions.NO:
            _previous_fd = signal.set_wakeup_fd(_pipe[1], warn_on_full_buffer=False)
        for wanted, number in (
            (SignalHandlerOptions.SIGINT, signal.SIGINT),
            (SignalHandlerOptions.SIGTERM, signal.SIGTERM),
        ):
            if options & wanted:
                _take_over(number)
        _current = SignalHandlerOptions(_current | options)


def _take_over(number: int) -> None:
    """Make sure that a signal reaches the pipe: it does if it has a handler in Python."""
    if not callable(signal.getsignal(number)):
        _replaced[number] = signal.signal(number, _quiet)
    _handlers[number] = signal.getsignal(number)


def get_current_signal_handlers_options() -> SignalHandlerOptions:
    """Return which signals are listened to."""
    return _current


def uninstall_signal_handlers() -> None:
    """Stop listening to signals, and give back the handlers that were there before."""
    global _current
    with _lock:
        if _current == SignalHandlerOptions.NO:
            return
        if threading.current_thread() is not threading.main_thread():
            return
        signal.set_wakeup_fd(_previous_fd)
        for number, handler in _replaced.items():
            if signal.getsignal(number) is _quiet:
                signal.signal(number, handler if handler is not None else signal.SIG_DFL)
        _replaced.clear()
        _handlers.clear()
        _current = SignalHandlerOptions.NO


def _listen(source: int) -> None:
    while True:
        for number in os.read(source, 64):
            # Someone who sets a handler of his own later has taken the signal over.
            if number in _handlers and signal.getsignal(number) is _handlers[number]:
                for living in list(_context._contexts):
                    living._invalidate()
            if _previous_fd >= 0:
                os.write(_previous_fd, bytes([number]))


class SignalHandlerGuardCondition(GuardCondition):
    """A guard condition for executors; shutdown wakes them already, so it is never triggered."""

    def __init__(self, context: Any = None) -> None:
        super().__init__(callback=None, callback_group=None, context=context)
