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
    "force": {
        "N": 1.0,
        "mN": 1e-3,
        "kN": 1e3,
        "kgf": 9.80665,
        "lbf": 4.4482216152605,
        "kip": 4448.2216152605,
    },
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
    # Of an encoder: what one is worth the map has to say (counts_per_rev, counts_per_m).
    "counts": {"counts": 1.0},
    "counts per second": {"counts/s": 1.0},
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0},
}


# Other spellings, in lower case where upper and lower mean the same.
_SPELLINGS = {
    "meter": "m",
    "meters": "m",
    "metre": "m",
    "metres": "m",
    "millimeter": "mm",
    "millimeters": "mm",
    "micron": "um",
    "microns": "um",
    "inch": "in",
    "inches": "in",
    "radian": "rad",
    "radians": "rad",
    "rads": "rad",
    "degree": "deg",
    "degrees": "deg",
    "degs": "deg",
    "turn": "rev",
    "turns": "rev",
    "revs": "rev",
    "revolution": "rev",
    "revolutions": "rev",
    "rad/sec": "rad/s",
    "deg/sec": "deg/s",
    "degs/s": "deg/s",
    "dps": "deg/s",
    "rps": "rev/s",
    "turn/s": "rev/s",
    "turns/s": "rev/s",
    "m/sec": "m/s",
    "mm/sec": "mm/s",
    "r/min": "rpm",
    "rev/min": "rpm",
    "u/min": "rpm",
    "1/min": "rpm",
    "min^-1": "rpm",
    "newton": "N",
    "newtons": "N",
    "amp": "A",
    "amps": "A",
    "ampere": "A",
    "volt": "V",
    "volts": "V",
    "sec": "s",
    "secs": "s",
    "second": "s",
    "seconds": "s",
    "msec": "ms",
    "usec": "us",
    "nsec": "ns",
    "milliseconds": "ms",
    "microseconds": "us",
    "nanoseconds": "ns",
    "count": "counts",
    "cts": "counts",
    "cnt": "counts",
    "cnts": "counts",
    "inc": "counts",
    "incs": "counts",
    "increments": "counts",
    "tick": "counts",
    "ticks": "counts",
    "lsb": "counts",
    "pulses": "counts",
    "count/s": "counts/s",
    "cts/s": "counts/s",
    "inc/s": "counts/s",
    "ticks/s": "counts/s",
}
_RMS = {"arms", "a rms", "a_rms", "a(rms)", "aeff", "a_eff"}


def plain(unit: str) -> str:
    """The spelling of `UNITS` for one that a user may write: `Nm`, `N*m`, `N·m` and `N m` agree.

    A unit that is not known comes back as it is, but for blanks.
    """
    text = unit.strip().replace("µ", "u").replace("μ", "u").replace("°", "deg")
    if text.lower() in _SPELLINGS:
        return _SPELLINGS[text.lower()]
    text = text.replace("·", " ").replace("*", " ").replace("-", " ")
    text = " ".join(text.split())
    names = [name for units in UNITS.values() for name in units]
    if text in names:
        return text
    joined = {name.replace(" ", ""): name for name in names}
    tight = text.replace(" ", "")
    if tight in joined:
        return joined[tight]
    # RPM, Deg, MM: where only one unit is spelt so but for upper and lower case.
    alike = [name for key, name in joined.items() if key.lower() == tight.lower()]
    return alike[0] if len(alike) == 1 else text


def unknown_unit(word: str) -> str:
    """What to say of a unit that is not known: its name, and those that are."""
    shown = " ".join(word.split())[:40]
    hint = ""
    if shown == "%":
        return "unit % is of a rated value: give its unit, and a hundredth of it as scale"
    if shown.lower() in _RMS:
        hint = " (of amperes RMS: unit: A, scale: 1.4142)"
    known = ", ".join(name for units in UNITS.values() for name in units)
    return f"unit {shown} is not known{hint}; known are {known}"


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
