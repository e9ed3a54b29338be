"""The logger class, with its filters."""

from __future__ import annotations

import sys
from typing import Any

from rclpy.impl.logging_severity import LoggingSeverity
from rclpy_cyclone import console

# Filter -> its parameters; ``None`` marks one that must be given.
_FILTERS: dict[str, dict[str, Any]] = {
    "throttle": {"throttle_duration_sec": None, "throttle_time_source_type": "clock"},
    "skip_first": {"skip_first": None},
    "once": {"once": None},
}
_KNOWN = [name for params in _FILTERS.values() for name in params]


def get_filters_from_kwargs(**kwargs: Any) -> list[str]:
    """Return the filters that keyword arguments of a log call ask for.

    :raises TypeError: if an argument is unknown, or a filter lacks one it needs.
    """
    for name in kwargs:
        if name not in _KNOWN:
            raise TypeError(
                f'parameter "{name}" is not one of the recognized logging options "{_KNOWN}"'
            )
    wanted = []
    for name, params in _FILTERS.items():
        if not any(kwargs.get(p) for p in params):
            continue
        wanted.append(name)
        for param, default in params.items():
            if default is None and param not in kwargs:
                raise TypeError(
                    f'required parameter "{param}" not specified '
                    f'but is required for the the logging filter "{name}"'
                )
    return wanted


class _CallSite:
    """What is remembered of one place in the code that logs."""

    def __init__(self, severity: int, name: str, filters: list[str], kwargs: Any) -> None:
        self.identity = (severity, name, filters, dict(kwargs))
        self.seen = False
        self.last = 0
        self.clock = kwargs.get("throttle_time_source_type")
        if "throttle" in filters and self.clock is None:
            from rclpy.clock import Clock

            self.clock = Clock()
        if "throttle" in filters and not hasattr(self.clock, "now"):
            raise ValueError(
                f'Received throttle_time_source_type of "{self.clock}" is not a clock instance'
            )

    def check(self, severity: int, name: str, filters: list[str], kwargs: Any) -> None:
        mine = self.identity
        if severity != mine[0]:
            raise ValueError("Logger severity cannot be changed between calls.")
        if name != mine[1]:
            raise ValueError("Logger name cannot be changed between calls.")
        if filters != mine[2]:
            raise ValueError("Requested logging filters cannot be changed between calls.")
        if kwargs != mine[3]:
            raise ValueError("Logging filter parameters cannot be changed between calls.")

    def passes(self, filters: list[str], kwargs: Any) -> bool:
        seen, self.seen = self.seen, True
        if "throttle" in filters:
            now = self.clock.now().nanoseconds
            if now < self.last + kwargs["throttle_duration_sec"] * 1e9:
                return False
            self.last = now
        if "skip_first" in filters and not seen:
            return False
        return not ("once" in filters and seen)


class RcutilsLogger:
    """A logger. Loggers form a tree by the dots in their names.

    :param name: full name; empty for the root.
    """

    def __init__(self, name: str = "") -> None:
        self.name = name
        self._sites: dict[Any, _CallSite] = {}

    def get_child(self, name: str) -> RcutilsLogger:
        """Return the logger ``<this one's name>.<name>``.

        :raises ValueError: if the name is empty.
        """
        if not name:
            raise ValueError("Child logger name must not be empty.")
        return RcutilsLogger(f"{self.name}{console.SEPARATOR}{name}" if self.name else name)

    def set_level(self, level: int | LoggingSeverity) -> None:
        """Set the lowest severity that is logged; ``UNSET`` follows the parent."""
        console.set_level(self.name, LoggingSeverity(level))

    def get_effective_level(self) -> LoggingSeverity:
        """Return the lowest severity that is logged."""
        return LoggingSeverity(console.effective_level(self.name))

    def is_enabled_for(self, severity: int | LoggingSeverity) -> bool:
        """Say whether messages of a severity are logged."""
        return severity >= console.effective_level(self.name)

    def log(self, message: Any, severity: int | LoggingSeverity, **kwargs: Any) -> bool:
        """Log a message.

        :param message: the text.
        :param severity: its severity.
        :param name: log under another name.
        :param throttle_duration_sec: log from this line at most once within so many seconds,
            by the clock ``throttle_time_source_type``.
        :param skip_first: do not log from this line the first time.
        :param once: log from this line only once.
        :return: whether the message was logged.
        :raises TypeError: if an option is unknown or lacks another.
        :raises ValueError: if a line changes its severity, name or options between calls.
        """
        if severity < console.effective_level(self.name):
            return False
        severity = LoggingSeverity(severity)
        name = kwargs.pop("name", self.name)
        frame = sys._getframe(1)
        while frame.f_code.co_filename == __file__ and frame.f_back is not None:
            frame = frame.f_back
        code = frame.f_code
        filters = get_filters_from_kwargs(**kwargs) if kwargs else []
        # The same line may log in two places: tell them apart by the byte code position.
        key = (code, frame.f_lasti)
        site = self._sites.get(key)
        if site is None:
            site = self._sites[key] = _CallSite(severity, name, filters, kwargs)
        else:
            site.check(severity, name, filters, kwargs)
        if filters and not site.passes(filters, kwargs):
            return False
        console.log(severity, name, str(message), code.co_name, code.co_filename, frame.f_lineno)
        return True

    def debug(self, message: Any, **kwargs: Any) -> bool:
        """Log with severity ``DEBUG``; see :meth:`log`."""
        return self.log(message, LoggingSeverity.DEBUG, **kwargs)

    def info(self, message: Any, **kwargs: Any) -> bool:
        """Log with severity ``INFO``; see :meth:`log`."""
        return self.log(message, LoggingSeverity.INFO, **kwargs)

    def warning(self, message: Any, **kwargs: Any) -> bool:
        """Log with severity ``WARN``; see :meth:`log`."""
        return self.log(message, LoggingSeverity.WARN, **kwargs)

    def warn(self, message: Any, **kwargs: Any) -> bool:
        """Log with severity ``WARN``; the older name of :meth:`warning`."""
        return self.log(message, LoggingSeverity.WARN, **kwargs)

    def error(self, message: Any, **kwargs: Any) -> bool:
        """Log with severity ``ERROR``; see :meth:`log`."""
        return self.log(message, LoggingSeverity.ERROR, **kwargs)

    def fatal(self, message: Any, **kwargs: Any) -> bool:
        """Log with severity ``FATAL``; see :meth:`log`."""
        return self.log(message, LoggingSeverity.FATAL, **kwargs)
