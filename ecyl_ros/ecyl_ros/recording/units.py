"""Units that a map file may name, and what one of each is in SI."""

from __future__ import annotations

import math

_INCH = 0.0254

# Dimension -> unit -> SI. The first of each is the SI unit itself, the others the spellings and
# multiples that drives, data sheets and exports use.
UNITS: dict[str, dict[str, float]] = {
    "length": {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "nm": 1e-9, "in": _INCH},
    "speed": {"m/s": 1.0, "mm/s": 1e-3, "um/s": 1e-6, "mm/min": 1e-3 / 60.0, "in/s": _INCH},
    "angle": {
        "rad": 1.0,
        "mrad": 1e-3,
        "urad": 1e-6,
        "deg": math.pi / 180.0,
        "arcmin": math.pi / 10_800.0,
        "rev": math.tau,
    },
    "angular speed": {
        "rad/s": 1.0,
        "deg/s": math.pi / 180.0,
        "rev/s": math.tau,
        "rpm": math.tau / 60.0,
    },
    "force": {"N": 1.0, "mN": 1e-3, "kN": 1e3, "kgf": 9.80665, "lbf": 4.4482216152605},
    "torque": {
        "N m": 1.0,
        "mN m": 1e-3,
        "kN m": 1e3,
        "N cm": 1e-2,
        "kgf cm": 0.0980665,
        "lbf in": 0.1129848290276167,
    },
    "current": {"A": 1.0, "mA": 1e-3},
    "voltage": {"V": 1.0, "mV": 1e-3},
    "number": {"1": 1.0},
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0},
}


def plain(unit: str) -> str:
    """The spelling of `UNITS` for one that a user may write: `Nm`, `N*m`, `N·m` and `N m` agree."""
    text = unit.strip().replace("µ", "u").replace("μ", "u").replace("°", "deg")
    text = text.replace("·", " ").replace("*", " ").replace("-", " ")
    text = " ".join(text.split())
    joined = {name.replace(" ", ""): name for units in UNITS.values() for name in units}
    return text if text in joined.values() else joined.get(text.replace(" ", ""), text)


def dimension_of(unit: str) -> str | None:
    """Name of the dimension that a unit belongs to; None for one that is not known."""
    name = plain(unit)
    return next((dimension for dimension, units in UNITS.items() if name in units), None)


def in_si(unit: str) -> float:
    """What one of `unit` is in SI; KeyError for an unknown one."""
    name = plain(unit)
    for units in UNITS.values():
        if name in units:
            return units[name]
    raise KeyError(unit)
