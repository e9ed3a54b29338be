"""Validation of namespaces."""

from rclpy.exceptions import InvalidNamespaceException
from rclpy_cyclone import remapping


def validate_namespace(namespace: str) -> bool:
    """Return ``True`` for a valid (full) namespace.

    :raises InvalidNamespaceException: for any other.
    """
    error = remapping.namespace_error(namespace)
    if error:
        raise InvalidNamespaceException(namespace, *error)
    return True
