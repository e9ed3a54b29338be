"""Clocks: system, steady and ROS time."""

from __future__ import annotations

import threading
import time as _time
import weakref
from collections.abc import Callable
from enum import IntEnum
from typing import Any

from rclpy.clock_type import ClockType
from rclpy.context import Context
from rclpy.duration import Duration
from rclpy.exceptions import NotInitializedException
from rclpy.time import Time
from rclpy.utilities import get_default_context


class ClockChange(IntEnum):
    """What a time jump did to the source of time."""

    ROS_TIME_NO_CHANGE = 1
    ROS_TIME_ACTIVATED = 2
    ROS_TIME_DEACTIVATED = 3
    SYSTEM_TIME_NO_CHANGE = 4


class JumpThreshold:
    """Which jumps of a clock are worth a callback.

    :param min_forward: smallest jump ahead (positive), or ``None``.
    :param min_backward: smallest jump back (negative), or ``None``.
    :param on_clock_change: whether a change of the source of time counts.
    :raises ValueError: if a threshold has the wrong sign, or none is given.
    """

    def __init__(
        self,
        *,
        min_forward: Duration | None,
        min_backward: Duration | None,
        on_clock_change: bool = True,
    ) -> None:
        if min_forward is not None and min_forward.nanoseconds <= 0:
            raise ValueError("min_forward must be a positive non-zero duration")
        if min_backward is not None and min_backward.nanoseconds >= 0:
            raise ValueError("min_backward must be a negative non-zero duration")
        if min_forward is None and min_backward is None and not on_clock_change:
            raise ValueError("At least one jump threshold must be enabled")
        self.min_forward = min_forward
        self.min_backward = min_backward
        self.on_clock_change = on_clock_change

    def _exceeded(self, change: ClockChange, delta: int) -> bool:
        if change in (ClockChange.ROS_TIME_ACTIVATED, ClockChange.ROS_TIME_DEACTIVATED):
            return self.on_clock_change
        if self.min_forward is not None and delta >= self.min_forward.nanoseconds:
            return True
        return self.min_backward is not None and delta <= self.min_backward.nanoseconds


class TimeJump:
    """A jump of a clock: what changed, and by how much time went ahead."""

    def __init__(self, clock_change: ClockChange, delta: Duration) -> None:
        if not isinstance(clock_change, ClockChange):
            raise TypeError("clock_change must be an instance of rclpy.clock.ClockChange")
        self._clock_change = clock_change
        self._delta = delta

    @property
    def clock_change(self) -> ClockChange:
        """What changed."""
        return self._clock_change

    @property
    def delta(self) -> Duration:
        """By how much time went ahead."""
        return self._delta


class JumpHandle:
    """A registered pair of callbacks around the jumps of a clock."""

    def __init__(
        self,
        *,
        clock: Clock,
        threshold: JumpThreshold,
        pre_callback: Callable[[], None] | None,
        post_callback: Callable[[TimeJump], None] | None,
    ) -> None:
        if pre_callback is None and post_callback is None:
            raise ValueError("One of pre_callback or post_callback must be callable")
        if pre_callback is not None and not callable(pre_callback):
            raise ValueError("pre_callback must be callable if given")
        if post_callback is not None and not callable(post_callback):
            raise ValueError("post_callback must be callable if given")
        self._clock: Clock | None = clock
        self._threshold = threshold
        self._pre = pre_callback
        self._post = post_callback
        clock._jump_handles.append(self)

    def unregister(self) -> None:
        """End the registration."""
        clock, self._clock = self._clock, None
        if clock is not None and self in clock._jump_handles:
            clock._jump_handles.remove(self)

    def __enter__(self) -> JumpHandle:
        return self

    def __exit__(self, *exc: Any) -> None:
        self.unregister()


class Clock:
    """A clock of a kind; ``ClockType.ROS_TIME`` makes a :class:`ROSClock`.

    :param clock_type: kind of the clock.
    :raises TypeError: if it is no :class:`ClockType`.
    """

    _clock_type: ClockType
    _jump_handles: list[JumpHandle]
    _timers: weakref.WeakSet[Any]

    def __new__(cls, *, clock_type: ClockType = ClockType.SYSTEM_TIME) -> Clock:
        if not isinstance(clock_type, ClockType):
            raise TypeError("Clock type must be a ClockType enum")
        self = super().__new__(ROSClock if clock_type is ClockType.ROS_TIME else cls)
        self._clock_type = clock_type
        self._jump_handles = []
        self._timers = weakref.WeakSet()
        return self

    @property
    def clock_type(self) -> ClockType:
        """Kind of the clock."""
        return self._clock_type

    @property
    def handle(self) -> Clock:
        """The clock itself; there is no compiled part."""
        return self

    def __enter__(self) -> Clock:
        return self

    def __exit__(self, *exc: Any) -> None:
        return None

    def __repr__(self) -> str:
        return f"Clock(clock_type={self._clock_type.name})"

    def _now(self) -> int:
        if self._clock_type is ClockType.STEADY_TIME:
            return _time.monotonic_ns()
        return _time.time_ns()

    def _simulated(self) -> bool:
        return False

    def now(self) -> Time:
        """Return the time now."""
        return Time(nanoseconds=self._now(), clock_type=self._clock_type)

    def create_jump_callback(
        self,
        threshold: JumpThreshold,
        *,
        pre_callback: Callable[[], None] | None = None,
        post_callback: Callable[[TimeJump], None] | None = None,
    ) -> JumpHandle:
        """Have functions called before and after the clock jumps.

        :param threshold: which jumps count.
        :param pre_callback: called before, without arguments.
        :param post_callback: called after, with a :class:`TimeJump`.
        """
        return JumpHandle(
            clock=self, threshold=threshold, pre_callback=pre_callback, post_callback=post_callback
        )

    def sleep_until(self, until: Time, context: Context | None = None) -> bool:
        """Sleep until the clock reaches a time.

        :param until: the time.
        :param context: its shutdown ends the sleep.
        :return: whether the time was reached; ``False`` after a shutdown, or if ROS time was
            switched on or off meanwhile.
        :raises ValueError: if the time is of another kind of clock.
        :raises NotInitializedException: if the context is not valid.
        """
        context = get_default_context() if context is None else context
        if not context.ok():
            raise NotInitializedException()
        if until.clock_type != self._clock_type:
            raise ValueError("until's clock type does not match this clock's type")
        event = threading.Event()
        changed = False

        def on_jump(jump: TimeJump) -> None:
            nonlocal changed
            if jump.clock_change in (
                ClockChange.ROS_TIME_ACTIVATED,
                ClockChange.ROS_TIME_DEACTIVATED,
            ):
                changed = True
            if changed or self.now() >= until:
                event.set()

        context._on_invalid(event.set)
        threshold = JumpThreshold(min_forward=Duration(nanoseconds=1), min_backward=None)
        with self.create_jump_callback(threshold, post_callback=on_jump):
            while context.ok() and not changed:
                left = until.nanoseconds - self._now()
                if left <= 0:
                    break
                event.wait(None if self._simulated() else left * 1e-9)
                event.clear()
        if not context.ok() or changed:
            return False
        return self.now() >= until

    def sleep_for(self, rel_time: Duration, context: Context | None = None) -> bool:
        """Sleep for a span of time; see :meth:`sleep_until`."""
        return self.sleep_until(self.now() + rel_time, context)


class ROSClock(Clock):
    """A clock of ROS time: simulated time if there is such, else system time."""

    _active: bool
    _override: int

    def __new__(cls) -> ROSClock:
        self = super().__new__(cls, clock_type=ClockType.ROS_TIME)
        assert isinstance(self, ROSClock)
        self._active = False
        self._override = 0
        return self

    @property
    def ros_time_is_active(self) -> bool:
        """Whether time is simulated."""
        return self._active

    def _now(self) -> int:
        return self._override if self._active else _time.time_ns()

    def _simulated(self) -> bool:
        return self._active

    def _set_ros_time_is_active(self, enabled: bool) -> None:
        if enabled == self._active:
            return
        change = ClockChange.ROS_TIME_ACTIVATED if enabled else ClockChange.ROS_TIME_DEACTIVATED
        after = self._override if enabled else _time.time_ns()
        self._jump(change, after - self._now(), lambda: setattr(self, "_active", enabled))

    def set_ros_time_override(self, time: Time) -> None:
        """Set the simulated time.

        :raises TypeError: if it is no :class:`.Time`.
        """
        if not isinstance(time, Time):
            raise TypeError(
                f"Time must be specified as rclpy.time.Time. Received type: {type(time)}"
            )
        self._set_override(time.nanoseconds)

    def _set_override(self, nanoseconds: int) -> None:
        if not self._active:
            self._override = nanoseconds
            return
        delta = nanoseconds - self._override
        if self._jump_handles:
            self._jump(
                ClockChange.ROS_TIME_NO_CHANGE,
                delta,
                lambda: setattr(self, "_override", nanoseconds),
            )
            return
        self._override = nanoseconds
        if self._timers:
            for timer in list(self._timers):
                timer._jumped(ClockChange.ROS_TIME_NO_CHANGE, delta)

    def _jump(self, change: ClockChange, delta: int, apply: Callable[[], None]) -> None:
        told = [h for h in self._jump_handles if h._threshold._exceeded(change, delta)]
        for handle in told:
            if handle._pre is not None:
                handle._pre()
        apply()
        jump = TimeJump(change, Duration(nanoseconds=delta))
        for handle in told:
            if handle._post is not None:
                handle._post(jump)
        for timer in list(self._timers):
            timer._jumped(change, delta)
