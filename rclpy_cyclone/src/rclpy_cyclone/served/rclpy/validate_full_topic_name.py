"""Validation of full topic and service names."""

from rclpy.exceptions import InvalidServiceNameException, InvalidTopicNameException
from rclpy_cyclone import remapping


def validate_full_topic_name(name: str, *, is_service: bool = False) -> bool:
    """Return ``True`` for a valid full name.

    :param is_service: whether it is a service's.
    :raises InvalidTopicNameException: for an invalid topic name.
    :raises InvalidServiceNameException: for an invalid service name.
    """
    error = remapping.full_name_error(name, "topic name")
    if error:
        kind = InvalidServiceNameException if is_service else InvalidTopicNameException
        raise kind(name, *error)
    return True
