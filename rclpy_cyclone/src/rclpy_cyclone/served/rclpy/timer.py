"""Timers and rates."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

from rclpy._rclpy_pybind11 import RCLError
from rclpy._ready import Ready
from rclpy.clock import Clock, ClockChange
from rclpy.clock_type import ClockType
from rclpy.exceptions import InvalidHandle, ROSInterruptException
from rclpy.utilities import get_default_context


class Timer(Ready):
    """Calls a function at a fixed rate of a clock. Nodes offer ``create_timer`` for this.

    The schedule is absolute: a late call does not delay the next ones, and calls that were
    missed altogether are left out.

    :param callback: function without arguments.
    :param callback_group: the callback's group.
    :param timer_period_ns: period in nanoseconds.
    :param clock: the clock.
    :param context: the context, by default the default one.
    :param autostart: whether to start at once, rather than at :meth:`reset`.
    """

    def __init__(
        self,
        callback: Callable[[], Any] | None,
        callback_group: Any,
        timer_period_ns: int,
        clock: Clock,
        *,
        context: Any = None,
        autostart: bool = True,
    ) -> None:
        super().__init__()
        self._context = get_default_context() if context is None else context
        if timer_period_ns < 0:
            raise RCLError("failed to create timer: timer period must be non-negative")
        self._clock = clock
        self._period = int(timer_period_ns)
        self.callback = callback
        self.callback_group = callback_group
        self._canceled = not autostart
        self._last = clock._now()
        self._next = self._last + self._period
        clock._timers.add(self)

    def _pending(self) -> bool:
        return not self._canceled and self._clock._now() >= self._next

    def _take(self) -> tuple[Any, tuple[Any, ...]] | None:
        if self._destroyed or not self._pending():
            return None
        now = self._clock._now()
        self._last = now
        self._next += self._period
        if self._next < now:
            if self._period == 0:
                self._next = now
            else:
                self._next += (1 + (now - self._next - 1) // self._period) * self._period
        self._reschedule()
        return (self.callback, ()) if self.callback else None

    def _reschedule(self) -> None:
        executor = self._executor
        if executor is not None:
            executor._timers_changed()

    def _jumped(self, change: ClockChange, delta: int) -> None:
        """React to a jump of the clock (called after it)."""
        now = self._clock._now()
        if change in (ClockChange.ROS_TIME_ACTIVATED, ClockChange.ROS_TIME_DEACTIVATED):
            # Keep what was left of the period on the other time line.
            self._next += delta
            self._last += delta
        elif now < self._last:  # time went back
            self._next = now + self._period
            self._last = now
        self._reschedule()

    def _attach(self, executor: Any) -> None:
        super()._attach(executor)
        executor._timers.append(self)
        executor._timers_changed()

    def _detach(self) -> None:
        executor = self._executor
        super()._detach()
        if executor is not None and self in executor._timers:
            executor._timers.remove(self)
            executor._timers_changed()

    def destroy(self) -> None:
        """Release the timer; nodes offer ``destroy_timer`` for this."""
        self._clock._timers.discard(self)
        super().destroy()

    def _alive(self) -> None:
        if self._destroyed:
            raise InvalidHandle("cannot use Destroyable because destruction was requested")

    @property
    def clock(self) -> Clock:
        """The clock."""
        return self._clock

    @property
    def timer_period_ns(self) -> int:
        """The period in nanoseconds; a new one holds from the call after the next."""
        self._alive()
        return self._period

    @timer_period_ns.setter
    def timer_period_ns(self, value: int) -> None:
        self._alive()
        self._period = int(value)

    def is_ready(self) -> bool:
        """Say whether the time for the next call has come."""
        self._alive()
        return self._pending()

    def is_canceled(self) -> bool:
        """Say whether the timer was cancelled."""
        self._alive()
        return self._canceled

    def cancel(self) -> None:
        """Stop calling, until :meth:`reset`."""
        self._alive()
        self._canceled = True
        self._reschedule()

    def reset(self) -> None:
        """Start again: the next call is a period from now."""
        self._alive()
        self._next = self._clock._now() + self._period
        self._canceled = False
        self._reschedule()

    def time_since_last_call(self) -> int:
        """Return how long ago the last call was, in nanoseconds."""
        self._alive()
        return self._clock._now() - self._last

    def time_until_next_call(self) -> int | None:
        """Return how long it is to the next call in nanoseconds, ``None`` if cancelled."""
        self._alive()
        return None if self._canceled else self._next - self._clock._now()

    def _steady(self) -> bool:
        return self._clock.clock_type is ClockType.STEADY_TIME


class Rate:
    """Sleeps to a fixed rate. Nodes offer ``create_rate`` for this."""

    def __init__(self, timer: Timer, *, context: Any) -> None:
        self._timer = timer
        self._is_shutdown = False
        self._is_destroyed = False
        self._event = threading.Event()
        self._lock = threading.Lock()
        self._num_sleepers = 0
        self._timer.callback = self._event.set
        context._on_invalid(self._on_shutdown)

    def _on_shutdown(self) -> None:
        self._is_shutdown = True
        self.destroy()

    def destroy(self) -> None:
        """Wake all sleepers for good."""
        self._is_destroyed = True
        self._event.set()

    def sleep(self) -> None:
        """Sleep until the timer fires, which takes an executor in another thread.

        :raises ROSInterruptException: on shutdown.
        :raises RuntimeError: if the rate was destroyed.
        """
        if self._is_shutdown:
            raise ROSInterruptException()
        if self._is_destroyed:
            raise RuntimeError("Rate cannot sleep because it has been destroyed")
        if self._timer._destroyed:
            self.destroy()
            raise InvalidHandle("Rate cannot sleep because the timer has been destroyed")
        with self._lock:
            self._num_sleepers += 1
        try:
            self._event.wait()
        finally:
            with self._lock:
                self._num_sleepers -= 1
                if self._num_sleepers == 0:
                    self._event.clear()
            if self._is_shutdown:
                self.destroy()
                raise ROSInterruptException()
