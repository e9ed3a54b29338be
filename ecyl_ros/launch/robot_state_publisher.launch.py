"""Launch robot_state_publisher with the cylinder of a drive file, beside a drive that runs."""

from pathlib import Path

from launch.actions import OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

from ecyl_ros.drive.model_file import load_model
from ecyl_ros.export.mechanism import of
from ecyl_ros.export.urdf import urdf
from ecyl_ros.nodes.launch_parts import drive_arguments
from launch import LaunchDescription


def _publisher(context, *_):
    """The node, once the arguments are known."""
    drive = Path(LaunchConfiguration("drive").perform(context))
    description = urdf(of(load_model(drive), drive.stem))
    return [
        Node(
            package="robot_state_publisher",
            executable="robot_state_publisher",
            namespace=LaunchConfiguration("namespace"),
            parameters=[{"robot_description": ParameterValue(description, value_type=str)}],
            remappings=[("joint_states", LaunchConfiguration("joint_states"))],
        )
    ]


def generate_launch_description() -> LaunchDescription:
    """One process that turns joint states into transforms until it is stopped."""
    arguments = drive_arguments(joint_states=("ecyl/joint_states", "topic of the drive"))
    return LaunchDescription([*arguments, OpaqueFunction(function=_publisher)])
