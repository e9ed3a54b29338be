"""Launch the gap monitor beside a drive that runs already, here or on another machine."""

from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

from launch import LaunchDescription

TOPICS = ("reference", "joint_states", "current", "voltage")


def generate_launch_description() -> LaunchDescription:
    """One process that listens until it is stopped."""
    config = Path(get_package_share_directory("ecyl_ros"), "config")
    arguments = [
        DeclareLaunchArgument(
            "drive",
            default_value=str(config / "bench.yaml"),
            description="drive file with the nominal model, a ROS 2 parameter file",
        ),
        DeclareLaunchArgument(
            "realtime",
            default_value="false",
            description="of the drive: with it a command acts one tick later at the earliest",
        ),
        DeclareLaunchArgument(
            "window", default_value="4.0", description="s of the drive's time that are judged"
        ),
        DeclareLaunchArgument(
            "rotor_joint", default_value="rotor", description="name of the rotor in joint_states"
        ),
        DeclareLaunchArgument(
            "rod_joint", default_value="rod", description="name of the rod in joint_states"
        ),
        DeclareLaunchArgument("namespace", default_value="", description="of the drive's topics"),
        *(
            DeclareLaunchArgument(
                name, default_value=f"ecyl/{name}", description="topic of the drive"
            )
            for name in TOPICS
        ),
    ]

    def value(name: str, kind: type) -> ParameterValue:
        return ParameterValue(LaunchConfiguration(name), value_type=kind)

    monitor = Node(
        package="ecyl_ros",
        executable="gap_monitor",
        name="gap_monitor",
        namespace=LaunchConfiguration("namespace"),
        parameters=[
            LaunchConfiguration("drive"),
            {
                "realtime": value("realtime", bool),
                "window": value("window", float),
                "rotor_joint": value("rotor_joint", str),
                "rod_joint": value("rod_joint", str),
            },
        ],
        remappings=[(f"ecyl/{name}", LaunchConfiguration(name)) for name in TOPICS],
        output="screen",
    )
    return LaunchDescription([*arguments, monitor])
