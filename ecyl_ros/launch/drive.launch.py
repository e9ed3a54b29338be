"""Launch the drive: plant, controller, reference and analyser, and a recorder if `out` is given."""

from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from launch.actions import DeclareLaunchArgument, EmitEvent, RegisterEventHandler
from launch.conditions import IfCondition
from launch.event_handlers import OnProcessExit
from launch.events import Shutdown
from launch.substitutions import LaunchConfiguration, PythonExpression
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

from launch import LaunchDescription


def generate_launch_description() -> LaunchDescription:
    """One process per node; ends with the plant, or with the recorder if there is one."""
    config = Path(get_package_share_directory("ecyl_ros"), "config")
    arguments = [
        DeclareLaunchArgument(
            "drive",
            default_value=str(config / "bench.yaml"),
            description="drive file, a ROS 2 parameter file",
        ),
        DeclareLaunchArgument(
            "reference",
            default_value="sine:amplitude=5e-3,frequency=0.5",
            description="reference SPEC, or setpoint",
        ),
        DeclareLaunchArgument(
            "duration", default_value="0.0", description="seconds to run; 0: until stopped"
        ),
        DeclareLaunchArgument(
            "realtime",
            default_value="false",
            description="pace by the wall clock instead of in lockstep",
        ),
        DeclareLaunchArgument(
            "out",
            default_value="",
            description="recording to write; nothing is recorded without it",
        ),
        DeclareLaunchArgument("namespace", default_value="", description="of all nodes"),
    ]

    def value(name: str, kind: type) -> ParameterValue:
        return ParameterValue(LaunchConfiguration(name), value_type=kind)

    timed = {"realtime": value("realtime", bool), "duration": value("duration", float)}
    own = {
        "plant": timed,
        "controller": {"realtime": value("realtime", bool)},
        "reference": timed | {"reference": value("reference", str)},
        "analyser": {"realtime": value("realtime", bool)},
        "recorder": timed | {"out": value("out", str)},
    }
    recording = PythonExpression(["'", LaunchConfiguration("out"), "' != ''"])
    nodes = {
        name: Node(
            package="ecyl_ros",
            executable=name,
            name=name,
            namespace=LaunchConfiguration("namespace"),
            parameters=[LaunchConfiguration("drive"), parameters],
            output="screen",
            condition=IfCondition(recording) if name == "recorder" else None,
        )
        for name, parameters in own.items()
    }
    not_recording = PythonExpression(["'", LaunchConfiguration("out"), "' == ''"])
    ends = [
        RegisterEventHandler(
            OnProcessExit(target_action=nodes[name], on_exit=[EmitEvent(event=Shutdown())]),
            condition=IfCondition(condition),
        )
        for name, condition in (("plant", not_recording), ("recorder", recording))
    ]
    return LaunchDescription([*arguments, *ends, *nodes.values()])
