"""The compiled part of rclpy, as far as it is offered."""

from rclpy import _rclpy_pybind11 as rclpy_implementation  # noqa: F401
