"""Validation of parameter names."""

from rclpy.exceptions import InvalidParameterException


def validate_parameter_name(name: str) -> bool:
    """Return ``True`` for a valid parameter name, which is any but the empty one.

    :raises InvalidParameterException: for the empty one.
    """
    if not name:
        raise InvalidParameterException(name)
    return True
