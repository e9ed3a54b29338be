"""Launch the gap monitor beside a drive that runs already, here or on another machine."""

from launch.substitutions import LaunchConfiguration

from ecyl_ros.nodes.launch_parts import drive_arguments, drive_node, value
from launch import LaunchDescription

TOPICS = ("reference", "joint_states", "current", "voltage")


def generate_launch_description() -> LaunchDescription:
    """One process that listens until it is stopped."""
    topics = {name: (f"ecyl/{name}", "topic of the drive") for name in TOPICS}
    arguments = drive_arguments(
        realtime=("false", "of the drive: with it a command acts one tick later at the earliest"),
        window=("4.0", "s of the drive's time that are judged"),
        rotor_joint=("rotor", "name of the rotor in joint_states"),
        rod_joint=("rod", "name of the rod in joint_states"),
        **topics,
    )
    monitor = drive_node(
        "gap_monitor",
        {
            "realtime": value("realtime", bool),
            "window": value("window", float),
            "rotor_joint": value("rotor_joint", str),
            "rod_joint": value("rod_joint", str),
        },
        remappings=[(f"ecyl/{name}", LaunchConfiguration(name)) for name in TOPICS],
    )
    return LaunchDescription([*arguments, monitor])
