"""Writes `worn_drive.mcap` as another machine would have recorded it: a sqlite3 bag, and a CSV.

    python bags/other_machine.py out/other

makes `out/other/bag` (rosbag2 folder: a controller's state of its own type, joint states of two
joints, the current in mA as a plain number; some messages lost) and `out/other/drive.csv` (mm,
deg, rpm, mA, decimal commas, the rod counted the other way round). See docs/recordings.md.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from ecyl_ros.recording.reader import read_recording

STATE = "control_msgs/msg/JointTrajectoryControllerState"
DEFINITION = """std_msgs/Header header
string[] joint_names
trajectory_msgs/JointTrajectoryPoint reference
trajectory_msgs/JointTrajectoryPoint feedback
trajectory_msgs/JointTrajectoryPoint error
"""
LOST = range(4000, 4030)  # joint states that never arrived
ARRIVES_NS = 150_000  # after it was measured


def main() -> None:
    """Both recordings, into the folder named."""
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    recording = read_recording(Path(__file__).parent / "worn_drive.mcap")
    store = get_typestore(Stores.ROS2_JAZZY)
    store.register(get_types_from_msg(DEFINITION, STATE))
    types = store.types
    point, header = types["trajectory_msgs/msg/JointTrajectoryPoint"], types["std_msgs/msg/Header"]
    time, duration = types["builtin_interfaces/msg/Time"], types["builtin_interfaces/msg/Duration"]
    none = np.zeros(0)

    def points(position: float, velocity: float) -> object:
        return point(
            positions=np.array([position]),
            velocities=np.array([velocity]),
            accelerations=none,
            effort=none,
            time_from_start=duration(sec=0, nanosec=0),
        )

    with Writer(folder / "bag", version=9, storage_plugin=StoragePlugin.SQLITE3) as writer:
        kinds = {
            "/axis_controller/controller_state": STATE,
            "/joint_states": "sensor_msgs/msg/JointState",
            "/drive/current_ma": "std_msgs/msg/Float64",
        }
        topics = {
            name: writer.add_connection(name, kind, typestore=store) for name, kind in kinds.items()
        }
        for i, stamp in enumerate(recording.stamp_ns.tolist()):
            at = header(stamp=time(sec=stamp // 10**9, nanosec=stamp % 10**9), frame_id="")
            rod = float(recording.rod_position_m[i])
            asked = float(recording.reference_position_m[i])
            speed = float(recording.reference_velocity_m_per_s[i])
            messages = {
                "/axis_controller/controller_state": types[STATE](
                    header=at,
                    joint_names=["rod"],
                    reference=points(asked, speed),
                    feedback=points(rod, 0.0),
                    error=points(asked - rod, 0.0),
                ),
                "/joint_states": types["sensor_msgs/msg/JointState"](
                    header=at,
                    name=["rod", "motor"],
                    position=np.array([rod, recording.rotor_position_rad[i]]),
                    velocity=np.array([np.nan, recording.rotor_velocity_rad_per_s[i]]),
                    effort=none,
                ),
                "/drive/current_ma": types["std_msgs/msg/Float64"](
                    data=float(recording.current_q_a[i] * 1e3)
                ),
            }
            for name, message in messages.items():
                if name == "/joint_states" and i in LOST:
                    continue
                data = store.serialize_cdr(message, kinds[name])
                writer.write(topics[name], stamp + ARRIVES_NS, data)

    columns = {
        "time_ms": (recording.time_s * 1e3, ".3f"),
        "target_mm": (recording.reference_position_m * 1e3, ".7f"),
        "slide_mm": (recording.rod_position_m * -1e3, ".7f"),
        "motor_angle_deg": (np.rad2deg(recording.rotor_position_rad), ".7f"),
        "motor_speed_rpm": (recording.rotor_velocity_rad_per_s * 30.0 / np.pi, ".6f"),
        "Iq [mA]": (recording.current_q_a * 1e3, ".5f"),
    }
    with (folder / "drive.csv").open("w", encoding="utf-8") as file:
        file.write(";".join(columns) + "\n")
        for row in zip(*(values.tolist() for values, _ in columns.values()), strict=True):
            cells = (f"{v:{f}}" for v, (_, f) in zip(row, columns.values(), strict=True))
            file.write(";".join(cells).replace(".", ",") + "\n")


if __name__ == "__main__":
    main()
