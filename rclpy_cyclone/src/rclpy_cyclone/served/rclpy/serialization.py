"""Messages as CDR bytes."""

from __future__ import annotations

from typing import Any

from rclpy._rclpy_pybind11 import RMWError
from rclpy.type_support import check_for_type_support
from rclpy_cyclone.types import cdr


def serialize_message(message: Any) -> bytes:
    """Return the CDR representation of a message, with its four-byte header."""
    check_for_type_support(type(message))
    return bytes(cdr.serialise(message))


def deserialize_message(serialized_message: bytes, message_type: Any) -> Any:
    """Return the message a CDR representation stands for.

    :param serialized_message: the representation.
    :param message_type: class of the message.
    :raises RMWError: if it does not hold such a message.
    """
    check_for_type_support(message_type)
    try:
        return cdr.deserialise(bytes(serialized_message), message_type)
    except ValueError as error:
        raise RMWError(f"failed to deserialize ROS message: {error}") from error
