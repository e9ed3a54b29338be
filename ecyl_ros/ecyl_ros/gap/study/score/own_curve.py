"""A library effect withheld from the diagnosis and described instead: is it the effect's own curve?

The curve is taken from the equations that the stand-in runs on, at the table's own places.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from ....arrays import FloatArray
from ..case import Case, Values
from ..cylinder.stage import hidden_phases

Places = Mapping[str, FloatArray]
WITHIN = 0.1  # of the curve's RMS over what was visited
REPEATED = 1.5  # turns from which a recording tells an angle from a position


def _stribeck(values: Values, x: Places, phase: float) -> FloatArray:
    over = values["static_nm"] - values["coulomb_nm"]
    return values["coulomb_nm"] + over * np.exp(-((x["speed"] / values["stribeck_rad_s"]) ** 2))


def _wave(amplitude: str, periods: str, angle: str) -> Callable[[Values, Places, float], Any]:
    def value(values: Values, x: Places, phase: float) -> FloatArray:
        return values[amplitude] * np.sin(values.get(periods, 1.0) * x[angle] + phase)

    return value


# Port, and the value there by parameters, places and hidden phase. Forces are still at the rod.
_CURVES: dict[str, tuple[str, Callable[[Values, Places, float], Any]]] = {
    "rotor_coulomb_friction": ("rotor_friction", lambda v, x, _: v["coulomb_nm"]),
    "rotor_viscous_friction": (
        "rotor_friction",
        lambda v, x, _: v["viscous_nm_s_per_rad"] * np.abs(x["speed"]),
    ),
    "stribeck_friction": ("rotor_friction", _stribeck),
    "cogging_torque": ("rotor_torque", _wave("amplitude_nm", "periods_per_rev", "rotor_angle")),
    "load_coulomb_friction": ("load_friction", lambda v, x, _: v["coulomb_nm"]),
    "load_viscous_friction": (
        "load_friction",
        lambda v, x, _: v["viscous_nm_s_per_rad"] * np.abs(x["speed"]),
    ),
    "constant_load": ("load_torque", lambda v, x, _: -v["force_n"]),
    "spring_load": ("load_torque", lambda v, x, _: -v["stiffness_n_per_m"] * x["position"]),
    "periodic_disturbance": (
        "load_torque",
        lambda v, x, phase: (
            v["amplitude_n"] * np.sin(2.0 * np.pi * v["frequency_hz"] * x["time"] + phase)
        ),
    ),
    "current_sensor_offset": ("current_error", lambda v, x, _: v["offset_a"]),
    "encoder_eccentricity": ("rotor_angle_error", _wave("amplitude_rad", "", "rotor_angle")),
}
_AT_ROD = ("constant_load", "spring_load", "periodic_disturbance")


def has_own_curve(case: Case) -> bool:
    """Whether a static effect was withheld of a cylinder, so that a law could give it back."""
    static = case.kind == "withheld" and set(case.effects) <= set(_CURVES)
    return static and case.drives != "rigid"


def off_own_curve(law: Mapping[str, Any], case: Case) -> float | None:
    """RMS by which a law is off the withheld effect's curve, as a share of the curve's RMS.

    Over the places that were visited. None where the law acts elsewhere or depends on what cannot
    give the effect. A drag may be told as a torque against the direction of motion, and an angle
    that never went round as a position.
    """
    ((name, values),) = case.effects.items()
    port, curve = _CURVES[name]
    at = [np.array(law["table"][key]) for key in ("at", "at_2")[: len(law["of"])]]
    x = dict(zip(law["of"], np.meshgrid(*at, indexing="ij"), strict=True))
    if "position" in x and law["turns"].get("rotor_angle", np.inf) < REPEATED:
        x["rotor_angle"] = x["position"] / case.facts["rod_per_rotor_m"]
    try:
        true = np.asarray(curve(values, x, hidden_phases(name, case.seed)[0]), dtype=float)
    except KeyError:
        return None
    if name in _AT_ROD:
        true = true * case.facts["rod_per_rotor_m"]
    if law["port"] != port:
        way = x.get("direction", x.get("speed"))
        if law["port"] != port.replace("friction", "torque") or way is None:
            return None
        true = -true * np.sign(way)
    shape = tuple(one.size for one in at)
    found, seen = (np.array(law["table"][key]).reshape(shape) for key in ("values", "seen"))
    if not seen.any():
        return None
    true = np.broadcast_to(true, shape)
    off = np.sqrt(np.mean((found - true)[seen] ** 2))
    return float(off / np.sqrt(np.mean(true[seen] ** 2)))
