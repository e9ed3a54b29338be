"""Validation of node names."""

from rclpy.exceptions import InvalidNodeNameException
from rclpy_cyclone import remapping


def validate_node_name(node_name: str) -> bool:
    """Return ``True`` for a valid node name.

    :raises InvalidNodeNameException: for any other.
    """
    error = remapping.node_name_error(node_name)
    if error:
        raise InvalidNodeNameException(node_name, *error)
    return True
