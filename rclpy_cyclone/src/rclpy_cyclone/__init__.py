"""rclpy and the common ROS 2 messages over Cyclone DDS from PyPI, for machines without ROS 2.

This module is imported at every interpreter start (through a ``.pth`` file), so it imports
nothing but :mod:`sys`.
"""

import sys

__version__ = "0.2.0"

# Message packages served when no genuine rclpy is importable.
MESSAGE_PACKAGES = frozenset(
    (
        "action_msgs",
        "actionlib_msgs",
        "builtin_interfaces",
        "diagnostic_msgs",
        "geometry_msgs",
        "lifecycle_msgs",
        "nav_msgs",
        "rcl_interfaces",
        "rmw_dds_common",
        "rosbag2_interfaces",
        "rosgraph_msgs",
        "sensor_msgs",
        "service_msgs",
        "shape_msgs",
        "statistics_msgs",
        "std_msgs",
        "std_srvs",
        "stereo_msgs",
        "tf2_msgs",
        "trajectory_msgs",
        "type_description_interfaces",
        "unique_identifier_msgs",
        "visualization_msgs",
    )
)


class _Finder:
    """Last finder of ``sys.meta_path``: asked only for names that nobody else could find."""

    @staticmethod
    def find_spec(fullname, path=None, target=None):
        head = fullname.partition(".")[0]
        if head != "rclpy" and head not in MESSAGE_PACKAGES:
            return None
        from rclpy_cyclone import finder

        return finder.find_spec(fullname)


def install() -> None:
    """Let ``import rclpy`` and the message packages be served from here. Safe to call again."""
    if not any(
        f.__class__.__name__ == "_Finder" and f.__class__.__module__ == __name__
        for f in sys.meta_path
    ):
        sys.meta_path.append(_Finder())


def uninstall() -> None:
    """Stop serving names that are not imported yet."""
    sys.meta_path[:] = [f for f in sys.meta_path if not isinstance(f, _Finder)]


def active() -> str:
    """Say which rclpy this interpreter uses, or would use.

    :return: ``'rclpy_cyclone'``, ``'genuine'``, or ``'none'`` (neither is importable).
    """
    from rclpy_cyclone import finder

    return finder.active()
