"""Checks that a class is one of a message or service."""

from __future__ import annotations

from typing import Any

from rclpy_cyclone.types.classes import MessageMeta, ServiceMeta


def check_for_type_support(msg_or_srv_type: Any) -> None:
    """Check that a class was generated from a ROS 2 definition.

    :raises AttributeError: if not.
    """
    if not isinstance(msg_or_srv_type, (MessageMeta, ServiceMeta)):
        raise AttributeError(
            f"{msg_or_srv_type!r} has no attribute '_TYPE_SUPPORT'. It is not a ROS 2 message "
            "or service type served by rclpy_cyclone"
        )


def check_is_valid_msg_type(msg_type: Any) -> None:
    """Check that a class is a message's.

    :raises AttributeError: if it is no ROS 2 type.
    :raises RuntimeError: if it is a service's.
    """
    check_for_type_support(msg_type)
    if not isinstance(msg_type, MessageMeta):
        raise RuntimeError("The message type provided is not valid")


def check_is_valid_srv_type(srv_type: Any) -> None:
    """Check that a class is a service's.

    :raises AttributeError: if it is no ROS 2 type.
    :raises RuntimeError: if it is a message's.
    """
    check_for_type_support(srv_type)
    if not isinstance(srv_type, ServiceMeta):
        raise RuntimeError("The service type provided is not valid")
