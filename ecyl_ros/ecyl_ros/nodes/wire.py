"""Topics between the nodes, their quality of service, and stamps.

Two kinds of topics. *Telemetry* (`ecyl/reference`, `ecyl/joint_states`, `ecyl/current`,
`ecyl/voltage`) comes at the telemetry rate and is what recordings hold. The *control wire*
(`ecyl/control/...`) carries one set of messages per control tick between plant and controller.
Names are relative, so that a namespace moves the whole drive; in the root namespace they are the
contract's.
"""

from __future__ import annotations

import struct

from builtin_interfaces.msg import Time
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

REFERENCE = "ecyl/reference"
JOINT_STATES = "ecyl/joint_states"
CURRENT = "ecyl/current"
VOLTAGE = "ecyl/voltage"
SETPOINT = "ecyl/setpoint"
TRAJECTORY = "ecyl/trajectory"
TRACKING_ERROR = "ecyl/tracking_error"
# The gap monitor: the telemetry topics again, recorded less simulated, and their RMS over noise.
GAP_JOINT_STATES = "ecyl/gap/joint_states"
GAP_CURRENT = "ecyl/gap/current"
GAP_VOLTAGE = "ecyl/gap/voltage"
GAP_OVER_NOISE = "ecyl/gap/over_noise"  # with the signal's name behind

# Stamp of control tick 0, latched: whoever joins or starts again knows where the run began.
EPOCH = "ecyl/control/epoch"
# Stamp of the tick the plant waits at, said again and again while it waits.
WAITING = "ecyl/control/waiting"
# Samples for the controller, ahead of the plant's time; telemetry says each when its time has come.
CONTROL_REFERENCE = "ecyl/control/reference"
# What the sensors give at a tick, in one message: a second one would cost a tenth of the tick rate.
# Joints rotor and rod with position and velocity; "joints" d and q, whose effort is a current, A.
CONTROL_MEASUREMENT = "ecyl/control/measurement"
CONTROL_VOLTAGE = "ecyl/control/voltage"

CLOCK = "clock"  # /clock, unless two drives, each with its own time, run at once
DIAGNOSTICS = "/diagnostics"

ROTOR, ROD, LOAD = "rotor", "rod", "load"
MEASUREMENT_JOINTS = (ROTOR, ROD, "d", "q")
# The numbers of a measurement in the order of `plant.MEASURED`, as paths (see `TopicSpec`).
MEASUREMENT_FIELDS = (
    "rotor.position",
    "rotor.velocity",
    "rod.position",
    "rod.velocity",
    "d.effort",
    "q.effort",
)
VECTOR_DQ = ("vector.x", "vector.y")
TELEMETRY_JOINTS = (ROTOR, ROD, LOAD)
BASE_FRAME, ROD_FRAME, DQ_FRAME = "base", "rod", "dq0"

NANOSECONDS = 1_000_000_000

# The first thing after the four bytes of CDR header: int32 sec, uint32 nanosec.
_STAMP_LITTLE, _STAMP_BIG = struct.Struct("<iI"), struct.Struct(">iI")


def latched(depth: int = 1) -> QoSProfile:
    """Reliable, and the last `depth` messages reach whoever comes later."""
    return QoSProfile(
        depth=depth,
        reliability=ReliabilityPolicy.RELIABLE,
        durability=DurabilityPolicy.TRANSIENT_LOCAL,
    )


def lossless() -> QoSProfile:
    """Reliable and nothing dropped: for telemetry, so that a recorder gets every sample."""
    return QoSProfile(
        history=HistoryPolicy.KEEP_ALL, depth=0, reliability=ReliabilityPolicy.RELIABLE
    )


def telemetry(realtime: bool) -> QoSProfile:
    """Of a telemetry publisher: nothing dropped in lockstep, never held up in real time.

    A publisher that keeps all stands still while a subscriber that was killed is missed: 10 s.
    """
    return QoSProfile(depth=1000) if realtime else lossless()


def control(realtime: bool = False) -> QoSProfile:
    """Reliable with a short queue: plant and controller answer each other tick by tick.

    In real time only the newest message counts: who was kept waiting goes on from there.
    """
    depth = 1 if realtime else 16
    return QoSProfile(depth=depth, reliability=ReliabilityPolicy.RELIABLE)


def plant_time(realtime: bool) -> QoSProfile:
    """Of a subscription to telemetry that tells the plant's time; the newest in real time."""
    return control(realtime=True) if realtime else lossless()


def to_time(stamp_ns: int) -> Time:
    """ROS time message of a stamp in ns."""
    return Time(sec=stamp_ns // NANOSECONDS, nanosec=stamp_ns % NANOSECONDS)


def to_ns(stamp: Time) -> int:
    """Stamp in ns of a ROS time message."""
    return stamp.sec * NANOSECONDS + stamp.nanosec


def stamp_of(data: bytes) -> int:
    """Stamp in ns of a serialised message that begins with a header."""
    sec, nanosec = (_STAMP_LITTLE if data[1] & 1 else _STAMP_BIG).unpack_from(data, 4)
    return int(sec * NANOSECONDS + nanosec)
