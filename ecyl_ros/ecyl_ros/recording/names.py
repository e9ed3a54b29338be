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
# Words of what is put in from outside on purpose.
INJECTED = {"injected", "injection", "excitation", "feedforward", "disturbance", "shaker"}
# Words of a place: what has one can stick while its drive goes on.
PLACED = {
    *("position", "positions", "pos", "angle", "encoder", "enc", "displacement", "stroke", "slide"),
    *("theta", "travel"),
}
# Words of instants and counters of samples.
TIMED = {
    *("time", "timestamp", "stamp", "stamps", "clock", "t", "sec", "nanosec", "seq", "date"),
    *("datetime", "utc", "index", "sample"),
}


def words(name: str) -> set[str]:
    """The words of a name, in lower case: `motorTorque_Nm` has motor, torque and nm."""
    spaced = re.sub(r"([a-z0-9])([A-Z])", r"\1 \2", name)
    return {word.lower() for word in re.split(r"[^A-Za-z]+", spaced) if word}


def holds(name: str) -> bool:
    """Whether a name is of what may keep a value for long: a command, a state, an instant."""
    return bool(words(name) & (ASKED | INJECTED | TIMED | {"mode", "state", "status", "flag"}))
