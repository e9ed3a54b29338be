"""The topics of a recording: names, types, frames, and which field holds which signal.

The one table of them. Writer and reader follow it, and so do the nodes that publish and record.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

JOINT_STATE = "sensor_msgs/msg/JointState"
VECTOR3_STAMPED = "geometry_msgs/msg/Vector3Stamped"

JOINT_FIELDS = ("position", "velocity", "effort")
VECTOR_FIELDS = ("x", "y", "z")


@dataclass(frozen=True)
class TopicSpec:
    """One topic of a recording.

    Attributes:
        key: how the code and `--topics` flags call it, whatever its name on the graph.
        name: topic name.
        type: message type, `package/msg/Type`.
        frame_id: of the message header.
        signals: field path -> signal. A path is `joint.position|velocity|effort` for a
            JointState and `vector.x|y|z` for a Vector3Stamped. In a JointState written by this
            project an array that any path uses is filled for every joint (NaN where no path
            does), and one that none uses stays empty; an unused vector component is 0.
        joints: names of a JointState's joints, in order.
        optional_joints: names that may follow them where they are known.
    """

    key: str
    name: str
    type: str
    frame_id: str
    signals: Mapping[str, str] = field(default_factory=dict)
    joints: tuple[str, ...] = ()
    optional_joints: tuple[str, ...] = ()


REFERENCE = TopicSpec(
    key="reference",
    name="/ecyl/reference",
    type=JOINT_STATE,
    frame_id="rod",
    joints=("rod",),
    signals={
        "rod.position": "reference_position_m",
        "rod.velocity": "reference_velocity_m_per_s",
    },
)
JOINT_STATES = TopicSpec(
    key="joint_states",
    name="/ecyl/joint_states",
    type=JOINT_STATE,
    frame_id="base",
    joints=("rotor", "rod"),
    optional_joints=("load",),
    signals={
        "rotor.position": "rotor_position_rad",
        "rotor.velocity": "rotor_velocity_rad_per_s",
        "rotor.effort": "rotor_torque_nm",
        "rod.position": "rod_position_m",
        "rod.velocity": "rod_velocity_m_per_s",
        "rod.effort": "rod_force_n",
        "load.position": "load_position_rad",
        "load.velocity": "load_velocity_rad_per_s",
    },
)
CURRENT = TopicSpec(
    key="current",
    name="/ecyl/current",
    type=VECTOR3_STAMPED,
    frame_id="dq0",
    signals={"vector.x": "current_d_a", "vector.y": "current_q_a"},
)
VOLTAGE = TopicSpec(
    key="voltage",
    name="/ecyl/voltage",
    type=VECTOR3_STAMPED,
    frame_id="dq0",
    signals={"vector.x": "voltage_d_v", "vector.y": "voltage_q_v"},
)

# In canonical order: the order in which one sample's messages stand in a file.
TOPICS: tuple[TopicSpec, ...] = (REFERENCE, JOINT_STATES, CURRENT, VOLTAGE)


def renamed(
    names: Mapping[str, str], topics: tuple[TopicSpec, ...] = TOPICS
) -> tuple[TopicSpec, ...]:
    """The table with other topic names, given by key; KeyError for an unknown key."""
    unknown = set(names) - {topic.key for topic in topics}
    if unknown:
        raise KeyError(f"no topic called {sorted(unknown)[0]!r}")
    return tuple(replace(topic, name=names.get(topic.key, topic.name)) for topic in topics)
