"""How far a drive's constants may lie from its data sheet: stated in the drive file, or by default.

A tolerance is the half width that holds 95 % of healthy machines, what a data sheet's +- means. The
defaults are those of data-sheet practice; the table says where each comes from.
"""

from __future__ import annotations

import dataclasses
import difflib
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ..errors import InputError

EXACT = "exact"
ALL = "all"  # stands for every constant that is not stated by itself


@dataclass(frozen=True)
class Default:
    """The relative tolerance of a constant that a drive file says nothing of, and its source."""

    relative: float
    source: str


# Constants that may be uncertain. Those of the controller are settings, known unless stated.
CONSTANTS: dict[str, Default] = {
    "motor.resistance": Default(
        0.13, "10 % at 25 degC on data sheets, and copper's 0.39 %/K over +-20 K of winding"
    ),
    "motor.inductance": Default(0.2, "20 % on data sheets; it falls with saturation"),
    "motor.torque_constant": Default(0.1, "10 % on data sheets; magnets lose 0.1 to 0.2 %/K"),
    "motor.back_emf_constant": Default(0.1, "10 % on data sheets, as the torque constant"),
    "motor.rotor_inertia": Default(0.1, "10 % on data sheets"),
    "motor.viscous_friction": Default(0.5, "bearings and seals: grease, temperature, running in"),
    "transmission.lead": Default(2e-4, "travel deviation of a class 7 screw, 52 um in 300 mm"),
    "transmission.gear_ratio": Default(0.0, "a ratio of numbers of teeth"),
    "transmission.backlash": Default(0.3, "stated as a maximum, or measured on another piece"),
    "transmission.stiffness": Default(0.2, "calculated from parts in series"),
    "transmission.contact_damping": Default(
        0.5, "seldom stated, mostly an estimate; where it is left out, up to a damping ratio of 0.1"
    ),
    "load.inertia": Default(0.1, "from drawings: density, grease, cables, what is mounted"),
    "load.viscous_friction": Default(0.5, "seals, nut, guides: grease, temperature, running in"),
    "controller.feed_scale": Default(
        0.0, "a setting, of the lead on the sheet or of a measured one: as uncertain as the lead"
    ),
    "controller.position.kp": Default(0.0, "a setting"),
    "controller.position.ki": Default(0.0, "a setting"),
    "controller.speed.kp": Default(0.0, "a setting"),
    "controller.speed.ki": Default(0.0, "a setting"),
    "controller.current.kp": Default(0.0, "a setting"),
    "controller.current.ki": Default(0.0, "a setting"),
}

# The same of a rigid drive, of those that its file states.
RIGID: dict[str, Default] = {
    "actuation.gain": Default(0.1, "torque constant, force per volt: 10 % on data sheets"),
    "load.mass": CONSTANTS["load.inertia"],
    "load.inertia": CONSTANTS["load.inertia"],
    "load.viscous_friction": CONSTANTS["load.viscous_friction"],
    "load.coulomb_friction": Default(0.5, "seals, guides, preload: temperature, running in"),
    "load.constant_load": CONSTANTS["load.inertia"],
    "load.stiffness": CONSTANTS["transmission.stiffness"],
}

_PREFIX = "tolerances"
_LARGEST = 1.0  # relative: a constant that may as well be 0 is not known at all
_TEXT = re.compile(r"\s*([0-9.eE+-]+)\s*(.*?)\s*")

Stated = Mapping[str, float | str]


def stated_tolerances(
    flat: Mapping[str, Any],
    units: Mapping[str, str],
    source: str,
    constants: Mapping[str, Default] = CONSTANTS,
) -> dict[str, float | str]:
    """The `tolerances` of a drive file: {constant, or "all": relative, or text with a unit}.

    Args:
        flat: dotted parameters of the file; keys that are no tolerances are passed over.
        units: of each constant, SI.
        source: names the file in errors.
        constants: that may be uncertain in this kind of drive.

    Raises:
        InputError: a constant that has no tolerance, a unit that is not the constant's, a value
            that is no number or out of range.
    """
    found: dict[str, float | str] = {}
    for key, value in flat.items():
        if key != _PREFIX and not key.startswith(f"{_PREFIX}."):
            continue
        name = key.removeprefix(_PREFIX).removeprefix(".") or ALL
        if name != ALL and name not in constants:
            near = difflib.get_close_matches(name, constants, n=1)
            hint = f"did you mean {near[0]}?" if near else f"expected {', '.join(constants)} or all"
            raise InputError(f"{source}: {key}: no constant {name} has a tolerance; {hint}")
        found[name] = _stated(value, "" if name == ALL else units[name], key, source)
    return found


def _stated(value: Any, unit: str, key: str, source: str) -> float | str:
    """A relative tolerance as a number, one in the constant's unit as text, or `EXACT`."""
    other = f", or with its unit, '0.01 {unit}'" if unit else ""
    wanted = f"expected {EXACT}, a share from 0 to {_LARGEST:g} (0.05, or '5 %'){other}"
    problem = InputError(f"{source}: {key} = {value!r}, {wanted}")
    if value == EXACT:
        return EXACT
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        raise problem
    match = _TEXT.fullmatch(str(value))
    try:
        number, given = (float(match[1]), match[2]) if match else (math.nan, "")
    except ValueError:
        raise problem from None
    if not (math.isfinite(number) and number >= 0.0):
        raise problem
    if given and given not in ("%", unit):
        raise problem
    if given and given == unit:
        return f"{number!r} {unit}"
    number = number / 100.0 if given == "%" else number
    if number > _LARGEST:
        raise problem
    return number


def half_widths(
    nominal: Mapping[str, float], stated: Stated, constants: Mapping[str, Default] = CONSTANTS
) -> dict[str, float]:
    """Tolerance of each constant in its own unit, 0 where it is exact.

    Args:
        nominal: {constant: value}.
        stated: as `stated_tolerances` gives it. constants: that may be uncertain.
    """
    found = {}
    for key, value in nominal.items():
        default = constants[key].relative
        said = stated.get(key, stated.get(ALL) if default > 0.0 else None)
        if said == EXACT:
            found[key] = 0.0
        elif isinstance(said, str):
            found[key] = float(said.split()[0])
        else:
            found[key] = (default if said is None else said) * abs(value)
    return found


def constants_of(drive: Any) -> dict[str, float]:
    """Value of each of `CONSTANTS` in a drive; of a piecewise stiffness that of its first segment.

    drive: `DriveParameters`.
    """
    found = {}
    for key in CONSTANTS:
        value: Any = drive
        for part in key.split("."):
            value = getattr(value, part)
        found[key] = float(value[0]) if isinstance(value, tuple) else float(value)
    return found


def with_constants(drive: Any, values: Mapping[str, float]) -> Any:
    """The drive with other values of some constants, in their units.

    Further segments of a piecewise stiffness keep their ratio to the first. What its file left out
    is no longer so once it has a value.
    """
    groups: dict[str, Any] = {}
    for key, value in values.items():
        group, _, name = key.partition(".")
        old = groups.get(group, getattr(drive, group))
        if "." in name:  # a gain of a loop
            loop, _, gain = name.partition(".")
            changed = dataclasses.replace(getattr(old, loop), **{gain: value})
            groups[group] = dataclasses.replace(old, **{loop: changed})
        elif isinstance(given := getattr(old, name), tuple):
            scaled = tuple(one * value / given[0] for one in given)
            groups[group] = dataclasses.replace(old, **{name: scaled})
        else:
            groups[group] = dataclasses.replace(old, **{name: value})
    left_out = tuple(key for key in drive.left_out if key not in values)
    return dataclasses.replace(drive, **groups, left_out=left_out)
