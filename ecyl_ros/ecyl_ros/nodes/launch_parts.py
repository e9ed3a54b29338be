"""What the launch files share. They are loaded by path, so what they share stands here.

`launch` and `launch_ros` come with ROS 2 alone, and are imported where a launch file calls.
"""

from __future__ import annotations

import subprocess
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .launcher import CLOSE_PATIENCE_S, STOP_PATIENCE_S, processors

if TYPE_CHECKING:
    from launch.conditions import IfCondition
    from launch.events.process import ProcessExited
    from launch.launch_context import LaunchContext
    from launch.launch_description_entity import LaunchDescriptionEntity
    from launch_ros.actions import Node
    from launch_ros.parameter_descriptions import ParameterValue

PACKAGE = "ecyl_ros"


def drive_arguments(**described: tuple[str, str]) -> list[LaunchDescriptionEntity]:
    """`drive` and `namespace`, which every launch file takes, and between them its own.

    described: argument -> (default, description). What follows them finds in `drive` a file's path.
    """
    from launch.actions import DeclareLaunchArgument, OpaqueFunction

    first = {"drive": ("bench", "drive file, a ROS 2 parameter file, or the name of a profile")}
    last = {"namespace": ("", "of all nodes and topics")}
    arguments = [
        DeclareLaunchArgument(name, default_value=default, description=description)
        for name, (default, description) in (first | described | last).items()
    ]
    return [*arguments, OpaqueFunction(function=_find_drive)]


def _find_drive(context: LaunchContext) -> None:
    """Put the path of the drive file in the place of a profile's name.

    Without `resolve_drive`: the Python that launches need not have what that imports.
    """
    from ament_index_python.packages import get_package_share_directory

    given = context.launch_configurations["drive"]
    if Path(given).is_file():
        return
    config = Path(get_package_share_directory(PACKAGE), "config")
    profiles = {path.stem: path for path in sorted(config.glob("*.yaml"))}
    if given not in profiles:
        raise RuntimeError(
            f"drive:={given}: no such file; expected a ROS 2 parameter file or one of "
            f"{', '.join(profiles)}"
        )
    context.launch_configurations["drive"] = str(profiles[given])


def value(name: str, kind: type) -> ParameterValue:
    """An argument as a parameter's value, of the type the node declares."""
    from launch.substitutions import LaunchConfiguration
    from launch_ros.parameter_descriptions import ParameterValue

    return ParameterValue(LaunchConfiguration(name), value_type=kind)


def rate_parameter(context: LaunchContext) -> dict[str, float]:
    """`controller.rate` of every node, if the argument `rate` was given."""
    text = context.launch_configurations["rate"]
    if not text:
        return {}
    try:
        return {"controller.rate": float(text)}
    except ValueError:
        raise RuntimeError(f"rate:={text}: expected a control rate in Hz") from None


def drive_node(
    name: str,
    parameters: Mapping[str, Any],
    *,
    remappings: Sequence[tuple[str, Any]] = (),
    condition: IfCondition | None = None,
) -> Node:
    """The node `name` with the drive file's parameters and, over these, its own.

    It runs where `ecyl run` would have it, and is given as long to end: SIGINT, SIGTERM after
    `STOP_PATIENCE_S`, SIGKILL `CLOSE_PATIENCE_S` later.
    """
    from launch.substitutions import LaunchConfiguration
    from launch_ros.actions import Node
    from launch_ros.parameter_descriptions import ParameterValue

    given = ",".join(map(str, sorted(processors(name))))
    placed = {"processors": ParameterValue(given, value_type=str)}
    return Node(
        package=PACKAGE,
        executable=name,
        name=name,
        namespace=LaunchConfiguration("namespace"),
        parameters=[LaunchConfiguration("drive"), dict(parameters) | placed],
        remappings=list(remappings),
        condition=condition,
        output="screen",
        sigterm_timeout=f"{STOP_PATIENCE_S:g}",
        sigkill_timeout=f"{CLOSE_PATIENCE_S:g}",
    )


def ended(name: str) -> Callable[[ProcessExited, LaunchContext], list[LaunchDescriptionEntity]]:
    """What to do when the node `name` has ended: end all others, with the reason.

    The plant that has run its time leaves the end to the recorder, if there is one.
    """
    from launch.actions import EmitEvent, LogInfo
    from launch.events import Shutdown

    def on_exit(event: ProcessExited, context: LaunchContext) -> list[LaunchDescriptionEntity]:
        if context.is_shutdown:
            return []
        recording = context.launch_configurations.get("out", "") != ""
        if name == "plant" and event.returncode == 0 and recording:
            return []
        how = "is through" if event.returncode == 0 else f"ended with {event.returncode}"
        reason = f"the {name} node {how}: ending the graph"
        return [LogInfo(msg=reason), EmitEvent(event=Shutdown(reason=reason))]

    return on_exit


def check(context: LaunchContext) -> list[LaunchDescriptionEntity]:
    """In real time: say what round trip this machine holds, refuse a drive that asks for more.

    What is refused ends the launch with that line.
    """
    from ament_index_python.packages import get_package_prefix
    from launch.actions import LogInfo

    given = context.launch_configurations
    if given["realtime"].lower() not in ("true", "1", "yes", "on"):
        return []
    # By the nodes' own Python, which need not be the one that launches.
    command = [Path(get_package_prefix(PACKAGE), "lib", PACKAGE, "round_trip"), given["drive"]]
    if given["rate"]:
        command += ["--rate", given["rate"]]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError(done.stderr.strip())
    return [LogInfo(msg=done.stdout.strip())]
