"""Validation of topic and service names that are not expanded yet."""

from rclpy.exceptions import InvalidServiceNameException, InvalidTopicNameException
from rclpy_cyclone import remapping

TOPIC_SEPARATOR_STRING = "/"


def validate_topic_name(name: str, *, is_service: bool = False) -> bool:
    """Return ``True`` for a valid name: relative, private or full.

    :param is_service: whether it is a service's.
    :raises InvalidTopicNameException: for an invalid topic name.
    :raises InvalidServiceNameException: for an invalid service name.
    """
    error = remapping.topic_name_error(name)
    if error:
        kind = InvalidServiceNameException if is_service else InvalidTopicNameException
        raise kind(name, *error)
    return True
