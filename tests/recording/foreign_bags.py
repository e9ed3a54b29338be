"""Bags as other machines leave them, written without this project's writer."""

from __future__ import annotations

import sqlite3
import struct
from pathlib import Path

import numpy as np
from mcap.writer import Writer

from ecyl_ros.recording.bag import read_bag
from ecyl_ros.recording.bag_contents import Bag, in_time_order
from ecyl_ros.recording.messages import definition, typestore

CONTROLLER_STATE = """std_msgs/Header header
string[] joint_names
trajectory_msgs/JointTrajectoryPoint reference
trajectory_msgs/JointTrajectoryPoint feedback
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: trajectory_msgs/JointTrajectoryPoint
float64[] positions
float64[] velocities
float64[] accelerations
float64[] effort
builtin_interfaces/Duration time_from_start
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
================================================================================
MSG: builtin_interfaces/Duration
int32 sec
uint32 nanosec
"""
STATE_TYPE = "control_msgs/msg/JointTrajectoryControllerState"


def point(values: tuple[float, ...]) -> bytes:
    """A JointTrajectoryPoint of positions alone, aligned to 8 bytes from its own start."""
    data = struct.pack("<I", len(values))
    data += b"\0" * 4 + struct.pack(f"<{len(values)}d", *values)
    return data + struct.pack("<III", 0, 0, 0) + struct.pack("<iI", 0, 0)


def controller_state(stamp_ns: int, reference: float, feedback: float) -> bytes:
    """A JointTrajectoryControllerState of joints `base` and `cylinder`, written byte by byte."""
    body = struct.pack("<iI", stamp_ns // 10**9, stamp_ns % 10**9)
    body += struct.pack("<I", 1) + b"\0" * 4  # frame_id, padded
    body += struct.pack("<I", 2)
    for name in (b"base\0", b"cylinder\0"):
        body += b"\0" * (-len(body) % 4) + struct.pack("<I", len(name)) + name
    for value in (reference, feedback):
        body += b"\0" * (-len(body) % 4) + struct.pack("<I", 2)
        body += b"\0" * (-len(body) % 8) + struct.pack("<2d", -1.0, value)
        body += struct.pack("<III", 0, 0, 0) + struct.pack("<iI", 0, 0)
    return b"\0\1\0\0" + body


def foreign_mcap(path: Path, count: int = 60, **options: object) -> None:
    """A bag as a ros2_control machine leaves it: state, joints, commands; by the mcap package."""
    types = typestore().types
    with path.open("wb") as file:
        writer = Writer(file, **options)  # type: ignore[arg-type]
        writer.start("ros2", "test")
        channels = {}
        for name, kind, text in (
            ("/controller/state", STATE_TYPE, CONTROLLER_STATE),
            ("/commands", "std_msgs/msg/Float64MultiArray", None),
            ("/joint_states", "sensor_msgs/msg/JointState", None),
        ):
            schema = writer.register_schema(kind, "ros2msg", (text or definition(kind)).encode())
            channels[name] = writer.register_channel(name, "cdr", schema)
        for i in range(count):
            at = 10**9 + i * 10**6
            value = 0.01 * np.sin(0.1 * i)
            layout = types["std_msgs/msg/MultiArrayLayout"](dim=[], data_offset=0)
            commands = types["std_msgs/msg/Float64MultiArray"](
                layout=layout, data=np.array([value, -1.0])
            )
            stamp = types["builtin_interfaces/msg/Time"](sec=at // 10**9, nanosec=at % 10**9)
            joints = types["sensor_msgs/msg/JointState"](
                header=types["std_msgs/msg/Header"](stamp=stamp, frame_id=""),
                name=["base", "cylinder"],
                position=np.array([0.0, value]),
                velocity=np.array([0.0, value]),
                effort=np.array([0.0, 10.0 * value]),
            )
            for name, data in (
                ("/controller/state", controller_state(at, value, value + 1e-5)),
                ("/commands", typestore().serialize_cdr(commands, commands.__msgtype__)),
                ("/joint_states", typestore().serialize_cdr(joints, joints.__msgtype__)),
            ):
                writer.add_message(channels[name], at + 200_000, bytes(data), at + 200_000)
        writer.finish()


def as_sqlite(source: Path, target: Path) -> None:
    """The same messages as a sqlite3 bag."""
    write_sqlite(read_bag(source), target)


def write_sqlite(bag: Bag, target: Path) -> None:
    """A sqlite3 bag of rosbag2's fourth schema, by sqlite3 alone."""
    base = sqlite3.connect(target)
    base.executescript(
        """
        PRAGMA synchronous = OFF;
        CREATE TABLE schema(schema_version INTEGER PRIMARY KEY, ros_distro TEXT NOT NULL);
        CREATE TABLE metadata(id INTEGER PRIMARY KEY, metadata_version INTEGER NOT NULL,
                              metadata TEXT NOT NULL);
        CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL,
                            serialization_format TEXT NOT NULL,
                            offered_qos_profiles TEXT NOT NULL,
                            type_description_hash TEXT NOT NULL);
        CREATE TABLE message_definitions(id INTEGER PRIMARY KEY, topic_type TEXT NOT NULL,
                                         encoding TEXT NOT NULL,
                                         encoded_message_definition TEXT NOT NULL,
                                         type_description_hash TEXT NOT NULL);
        CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL,
                              timestamp INTEGER NOT NULL, data BLOB NOT NULL);
        CREATE INDEX timestamp_idx ON messages (timestamp ASC);
        INSERT INTO schema VALUES (4, 'jazzy');
        """
    )
    ids = {name: i + 1 for i, name in enumerate(bag.topics)}
    for name, topic in bag.topics.items():
        base.execute(
            "INSERT INTO topics VALUES (?, ?, ?, 'cdr', '', '')", (ids[name], name, topic.type)
        )
        base.execute(
            "INSERT INTO message_definitions VALUES (?, ?, ?, ?, '')",
            (ids[name], topic.type, topic.definition_encoding, topic.definition),
        )
    base.executemany(
        "INSERT INTO messages(topic_id, timestamp, data) VALUES (?, ?, ?)",
        ((ids[name], stamp, data) for stamp, name, data in in_time_order(bag)),
    )
    base.commit()
    base.close()
