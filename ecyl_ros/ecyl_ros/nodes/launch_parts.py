"""What the launch files share. They are loaded by path, so what they share stands here.

`launch` and `launch_ros` come with ROS 2 alone, and are imported where a launch file calls.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from launch.actions import DeclareLaunchArgument
    from launch.conditions import IfCondition
    from launch_ros.actions import Node
    from launch_ros.parameter_descriptions import ParameterValue

PACKAGE = "ecyl_ros"


def drive_arguments(**described: tuple[str, str]) -> list[DeclareLaunchArgument]:
    """`drive` and `namespace`, which every launch file takes, and between them its own.

    described: argument -> (default, description).
    """
    from ament_index_python.packages import get_package_share_directory
    from launch.actions import DeclareLaunchArgument

    config = Path(get_package_share_directory(PACKAGE), "config")
    first = {"drive": (str(config / "bench.yaml"), "drive file, a ROS 2 parameter file")}
    last = {"namespace": ("", "of all nodes and topics")}
    return [
        DeclareLaunchArgument(name, default_value=default, description=description)
        for name, (default, description) in (first | described | last).items()
    ]


def value(name: str, kind: type) -> ParameterValue:
    """An argument as a parameter's value, of the type the node declares."""
    from launch.substitutions import LaunchConfiguration
    from launch_ros.parameter_descriptions import ParameterValue

    return ParameterValue(LaunchConfiguration(name), value_type=kind)


def drive_node(
    name: str,
    parameters: Mapping[str, Any],
    *,
    remappings: Sequence[tuple[str, Any]] = (),
    condition: IfCondition | None = None,
) -> Node:
    """The node `name` with the drive file's parameters and, over these, its own."""
    from launch.substitutions import LaunchConfiguration
    from launch_ros.actions import Node

    return Node(
        package=PACKAGE,
        executable=name,
        name=name,
        namespace=LaunchConfiguration("namespace"),
        parameters=[LaunchConfiguration("drive"), dict(parameters)],
        remappings=list(remappings),
        condition=condition,
        output="screen",
    )
