"""Loggers and their levels."""

from __future__ import annotations

import os
from pathlib import Path

from rclpy.impl.logging_severity import LoggingSeverity
from rclpy.impl.rcutils_logger import RcutilsLogger
from rclpy_cyclone import console

_root_logger = RcutilsLogger()


def get_logger(name: str) -> RcutilsLogger:
    """Return the logger of a name.

    :raises ValueError: if the name is empty.
    """
    if not name:
        raise ValueError("Logger name must not be empty.")
    return _root_logger.get_child(name)


def initialize() -> None:
    """Set up the logging; nothing needs to be done."""


def shutdown() -> None:
    """Forget the loggers' levels."""
    console.levels.clear()


def clear_config() -> None:
    """Forget the loggers' levels."""
    shutdown()
    initialize()


def set_logger_level(name: str, level: int | LoggingSeverity, detailed_error: bool = False) -> None:
    """Set the level of a logger; ``UNSET`` makes it follow its parent."""
    console.set_level(name, LoggingSeverity(level))


def get_logger_effective_level(name: str) -> LoggingSeverity:
    """Return the level a logger works at, its own or an ancestor's."""
    return LoggingSeverity(console.effective_level(name))


def get_logger_level(name: str) -> LoggingSeverity:
    """Return a logger's own level, ``UNSET`` if it has none."""
    return LoggingSeverity(console.levels.get(name, 0))


def get_logging_severity_from_string(log_severity: str) -> LoggingSeverity:
    """Return the severity of a word such as ``'info'``, in any case.

    :raises RuntimeError: if there is none.
    """
    try:
        return LoggingSeverity[log_severity.upper()]
    except KeyError:
        raise RuntimeError("Failed to get severity name") from None


def get_logging_directory() -> Path:
    """Return the folder ROS 2 would write log files to. None are written here."""
    if given := os.environ.get("ROS_LOG_DIR"):
        return Path(given).expanduser()
    home = os.environ.get("ROS_HOME", "~/.ros")
    return Path(home).expanduser() / "log"
