"""Exceptions and enumerations that rclpy defines in its compiled part."""

import builtins
from enum import IntEnum

from rclpy.clock_type import ClockType  # noqa: F401  (rclpy offers it here too)


class RCUtilsError(RuntimeError):
    """A failure in the logging or utility layer."""


class RMWError(RuntimeError):
    """A failure in the middleware layer."""


class RCLError(RuntimeError):
    """A failure in the client library."""


class RCLInvalidROSArgsError(RCLError):
    """ROS arguments are malformed."""


class UnknownROSArgsError(RuntimeError):
    """There are ROS arguments nobody knows."""


class NodeNameNonExistentError(RCLError):
    """There is no node of the given name in the graph."""


class UnsupportedEventTypeError(RCLError):
    """The middleware does not offer such events."""


class NotImplementedError(builtins.NotImplementedError):
    """The middleware does not implement this."""


class InvalidHandle(RuntimeError):
    """The entity was destroyed already."""


class SignalHandlerOptions(IntEnum):
    """Which signals the context shall be shut down by."""

    NO = 0
    SIGINT = 1
    SIGTERM = 2
    ALL = 3


class QoSCompatibility(IntEnum):
    """Verdict of :func:`rclpy.qos.qos_check_compatible`."""

    OK = 0
    WARNING = 1
    ERROR = 2
