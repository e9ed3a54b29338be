"""What the names of topics, fields and columns say: their words, and which of them ask."""

from __future__ import annotations

import re

# Words of what a drive is told, rather than of what it does.
ASKED = {
    "reference",
    "ref",
    "desired",
    "des",
    "setpoint",
    "sp",
    "command",
    "commands",
    "commanded",
    "cmd",
    "target",
    "goal",
    "demand",
    "set",
    "control",
    "qg",
}
# Words of what a sensor gave, where the same is there as it was told or worked out, too.
MEASURED = {"meas", "measured", "actual", "act", "feedback", "fb", "sensor", "sensed"}
# Words of what is put in from outside on purpose.
INJECTED = {"injected", "injection", "excitation", "feedforward", "disturbance", "shaker"}
# Words of a place: what has one can stick while its drive goes on.
PLACED = {
    *("position", "positions", "pos", "angle", "angles", "ang", "encoder", "enc", "displacement"),
    *("stroke", "slide", "theta", "travel"),
}
# Words of instants and counters of samples.
TIMED = {
    *("time", "timestamp", "stamp", "stamps", "clock", "t", "sec", "nanosec", "seq", "date"),
    *("timestep", "datetime", "utc", "index", "sample"),
}

# Words in names -> what they speak of. Whole words: `pos`, not `composite`.
QUANTITY = {
    "position": "position",
    "positions": "position",
    "pos": "position",
    **dict.fromkeys(("angle", "angles", "ang"), "position"),
    "theta": "position",
    "displacement": "position",
    "stroke": "position",
    "q": "position",
    "qm": "position",
    "qg": "position",
    "x": "position",
    "velocity": "velocity",
    "velocities": "velocity",
    "vel": "velocity",
    "speed": "velocity",
    "omega": "velocity",
    "rpm": "velocity",
    **dict.fromkeys(("dq", "qd", "qdot", "dtheta", "thetadot", "dx", "xd", "xdot"), "velocity"),
    "effort": "effort",
    "efforts": "effort",
    "torque": "effort",
    "torques": "effort",
    "trq": "effort",
    "tau": "effort",
    "force": "effort",
    **dict.fromkeys(("current", "amps", "iq"), "current_q"),
    "id": "current_d",
    **dict.fromkeys(("voltage", "volts", "uq", "vq"), "voltage_q"),
    "ud": "voltage_d",
    "vd": "voltage_d",
}
# Words of bodies, of what goes round, of what a supply gives, and of numbers in counts.
ROTOR = {"rotor", "motor", "mot", "servo", "encoder", "enc"}
ENCODERS = {"encoder", "enc"}
ROD = {"rod", "cylinder", "piston", "slider", "carriage", "stage", "linear", "ram", "axis"}
TURNS = {
    *("angle", "angles", "ang"),
    *("theta", "thetadot", "dtheta", "phi", "omega", "rpm", "q", "dq", "qd", "qdot", "qm"),
    "qg",
}
SUPPLY = {"bus", "vbus", "ibus", "dc", "vdc", "idc", "supply", "battery", "link", "mains"}
FORCE = {"force"}
TORQUE = {"torque", "torques", "trq", "tau"}
JOINT = {"joint", "joints"}
# Words of robots' columns, whose number at the end is the joint's: `dq_1`, `tau2`.
NUMBERED = {"q", "dq", "qd", "qdot", "qm", "tau", *JOINT}
# Words of the parts of an arm, a leg, a head or a balancing machine, each a joint of its own.
PARTS = {
    *("shoulder", "elbow", "wrist", "hip", "thigh", "knee", "calf", "ankle", "waist", "torso"),
    *("neck", "finger", "thumb", "left", "right", "front", "rear", "pan", "tilt", "yaw", "pitch"),
    *("roll", "azimuth", "elevation", "frame", "wheel", "flywheel", "cart", "pendulum", "pole"),
}
# Words of what stands beside a signal and is none.
NO_SIGNAL = {
    *("error", "err", "covariance", "timestamp", "time", "stamp", "acceleration", "acc"),
    *("ddq", "qdd", "qddot", "ddtheta", "thetaddot", "ddx", "xdd", "xddot"),
    *("temp", "temperature", "pressure", "humidity", "gyro", "imu"),
}
COUNTED = {"counts", "count", "ticks", "increments", "raw", "pulses"}


def ordered(name: str) -> list[str]:
    """The words of a name as they stand, in lower case: a derivative, `q_dot`, is one word, and
    capitals end where the next word begins, `DCBusVoltage`."""
    spaced = re.sub(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", " ", name)
    out: list[str] = []
    for word in (one.lower() for one in re.split(r"[^A-Za-z]+", spaced) if one):
        if word in ("dot", "ddot") and out:
            out[-1] += word
        else:
            out.append(word)
    return out


def words(name: str) -> set[str]:
    """The words of a name, in lower case: `motorTorque_Nm` has motor, torque and nm."""
    return set(ordered(name))


def holds(name: str) -> bool:
    """Whether a name is of what may keep a value for long: a command, a state, an instant."""
    return bool(words(name) & (ASKED | INJECTED | TIMED | {"mode", "state", "status", "flag"}))


def name_of(place: int) -> str:
    """The name of a column that its table gives none: `column_3`."""
    return f"column_{place}"


def unnamed(name: str) -> bool:
    """Whether a column has such a name, which says nothing of what it holds."""
    return re.fullmatch(r"column_\d+", name) is not None
