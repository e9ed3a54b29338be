"""Launch the drive: plant, controller, reference and analyser; a recorder if `out` is given; the
gap monitor beside them with `monitor:=true`.

Two drives at once: launch it twice, each with a `namespace` of its own.
"""

from launch.actions import OpaqueFunction, RegisterEventHandler
from launch.conditions import IfCondition
from launch.event_handlers import OnProcessExit
from launch.substitutions import LaunchConfiguration, PythonExpression

from ecyl_ros.nodes.launch_parts import (
    check,
    drive_arguments,
    drive_node,
    ended,
    rate_parameter,
    value,
)
from launch import LaunchDescription


def generate_launch_description() -> LaunchDescription:
    """One process per node; when one that is needed has ended, so do the others."""
    arguments = drive_arguments(
        reference=("sine:amplitude=5e-3,frequency=0.5", "reference SPEC, or setpoint"),
        duration=("0.0", "seconds to run; 0: until stopped"),
        realtime=("false", "pace by the wall clock instead of in lockstep"),
        rate=("", "control rate, Hz, instead of the drive file's"),
        out=("", "recording to write; nothing is recorded without it"),
        monitor=("false", "run the nominal model of the drive file beside the drive"),
    )
    return LaunchDescription(
        [*arguments, OpaqueFunction(function=check), OpaqueFunction(function=_graph)]
    )


def _graph(context):
    """The nodes, once the arguments are known."""
    common = {"realtime": value("realtime", bool)} | rate_parameter(context)
    timed = common | {"duration": value("duration", float)}
    own = {
        "plant": timed,
        "controller": common,
        "reference": timed | {"reference": value("reference", str)},
        "analyser": common,
        "recorder": timed | {"out": value("out", str)},
        "gap_monitor": common,
    }
    recording = PythonExpression(["'", LaunchConfiguration("out"), "' != ''"])
    conditions = {
        "recorder": IfCondition(recording),
        "gap_monitor": IfCondition(LaunchConfiguration("monitor")),
    }
    nodes = {
        name: drive_node(name, parameters, condition=conditions.get(name))
        for name, parameters in own.items()
    }
    ends = [
        RegisterEventHandler(OnProcessExit(target_action=nodes[name], on_exit=ended(name)))
        for name in ("plant", "controller", "reference", "recorder")
    ]
    return [*ends, *nodes.values()]
