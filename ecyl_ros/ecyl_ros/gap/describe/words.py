"""What a described cause is called: where it acts, what it depends on, how."""

from __future__ import annotations

import numpy as np

from ...drive.law import Law, order_of

PLACES = {
    "rotor_torque": "a torque on the rotor",
    "rotor_friction": "a drag on the rotor",
    "load_torque": "a torque on the load",
    "load_friction": "a drag on the load",
    "inverter_voltage": "a voltage at the winding",
    "rotor_angle_error": "an error of the rotor's encoder",
    "current_error": "an error of the current's reading",
    "rod_error": "an error of the rod's scale",
    "following_error": "a departure of the output from its reference",
}
BLOCKS = {
    "rotor_torque": "motor_mechanical",
    "rotor_friction": "motor_mechanical",
    "load_torque": "load",
    "load_friction": "load",
    "inverter_voltage": "motor_electrical",
    "rotor_angle_error": "sensor",
    "current_error": "sensor",
    "rod_error": "sensor",
}
VARIABLES = {
    "position": "position",
    "rotor_angle": "the rotor's angle",
    "screw_angle": "the screw's angle",
    "speed": "speed",
    "direction": "the direction of motion",
    "current": "current",
    "torque": "the torque that the transmission carries",
    "voltage": "voltage",
    "time": "time",
    "heat": "heat (current squared, filtered)",
    "travel": "the travel since the last reversal",
}
_EVEN = 0.1  # share of a table's power that may be of the other symmetry
_REPEATS = 0.6  # share of a curve's variance in one wave


def place(law: Law) -> str:
    """Of what kind it is and where it acts."""
    kind = {"N m": "a torque", "N": "a force"}.get(law.unit, "an effort")
    return PLACES[law.port].replace("a torque", kind)


def depends(law: Law) -> str:
    """What it depends on, in words."""
    if not law.of:
        return f"that is always the same{', both ways' if law.of_friction else ''}"
    names = " and ".join(VARIABLES[one] for one in law.of)
    return f"that depends on {names}{_manner(law)}"


def closest(text: str, share: float, of: str) -> str:
    """What begins a note on the nearest law, which is not described; why it is not goes on from it.

    text: its words. share: that it removes; of: what.
    """
    gone = f"{100.0 * share:.0f} % of {of} on held-out data"
    return f"closest law, not described: {text} removes {gone}"


def _manner(law: Law) -> str:
    """How it runs, where that can be said in a few words."""
    said = ""
    if len(law.of) == 1:
        (name,), (places,) = law.of, law.at
        values = np.array(law.values)
        if law.periods[0] > 0.0:
            order = int(np.argmax(np.abs(np.fft.rfft(values - values.mean()))[1:])) + 1
            order *= order_of(name, law.periods[0])
            times = {1: "once", 2: "twice"}.get(order, f"{order} times")
            said = f", {times} a turn"
        elif name == "position":
            said = _repeating(values, places, law.units[0])
        elif name in ("speed", "current") and places[0] < 0.0 < places[-1]:
            said = _symmetry(values, np.array(places))
    if law.of_friction and not {"speed", "direction"} & set(law.of):
        said += ", the same both ways"
    return said


def _repeating(values: np.ndarray, places: tuple[float, ...], unit: str) -> str:
    centred = values - values.mean()
    power = np.abs(np.fft.rfft(centred)) ** 2
    order = int(np.argmax(power[1:])) + 1 if power[1:].any() else 0
    if order < 2 or power[order] < _REPEATS * power[1:].sum():
        return ""
    length = (places[-1] - places[0]) * len(places) / (len(places) - 1) / order
    length, unit = (1e3 * length, "mm") if unit == "m" else (length, unit)
    return f", about once per {float(f'{length:.2g}'):g} {unit}"


def _symmetry(values: np.ndarray, places: np.ndarray) -> str:
    reach = min(-places[0], places[-1])
    x = np.linspace(0.0, reach, 20)
    ahead, back = np.interp(x, places, values), np.interp(-x, places, values)
    even, odd = ahead + back, ahead - back
    whole = float(np.sum(even**2) + np.sum(odd**2))
    if whole > 0.0 and float(np.sum(odd**2)) < _EVEN * whole:
        return ", the same both ways"
    if whole > 0.0 and float(np.sum(even**2)) < _EVEN * whole:
        return ", against itself the other way"
    return ""
