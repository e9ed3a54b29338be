"""A learned law in a rigid drive (see `drive.law`): an effort along the motion of its output.

    effects:
      learned: {port: load_friction, of: [position], table: {at: [0.0, 0.1], values: [3.0, 5.0]}}

`load_torque` and `load_friction` are those of a straight output, `rotor_torque` and
`rotor_friction` of one that turns. A torque (or force) is positive where it drives; a friction is a
level on top of the file's own. Values are efforts in the output's N or N m, or in `unit` where the
gain is not known; position, speed and travel are the output's. Heat, the effort squared behind a
low-pass, and the travel since a reversal are taken as a recording shows them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray
from ...effects import learned
from ...errors import InputError
from ..compiled import kernel
from ..law import KEY, PORTS, VARIABLES, Law, law_from_flat, law_to_file
from ..memory import since_reversal, warmed
from .course import Course
from .units import EFFORT_UNITS, Units, own_effort

UNIT = f"{KEY}.unit"
TORQUE, FRICTION = 1, 2  # where a law acts, as it is packed
_OF = ("position", "speed", "direction", "time", "heat", "travel")
_DTYPE = np.dtype([*learned.FIELDS, ("rod_per_rotor", "f8"), ("gear_ratio", "f8")])


def law_of(flat: Mapping[str, Any], linear: bool, source: str) -> Law | None:
    """The law in the flat keys of a rigid drive's file; None where they hold none.

    Raises:
        InputError: as `drive.law.law_from_flat`; a port, variable or unit that it cannot have.
    """
    side = "load" if linear else "rotor"
    ports = {name: PORTS[name] for name in (f"{side}_torque", f"{side}_friction")}
    names = _OF if linear else ("rotor_angle", *_OF)
    rest = {key: value for key, value in flat.items() if key != UNIT}
    law = law_from_flat(rest, source, ports, {name: VARIABLES[name] for name in names})
    if law is None:
        if UNIT in flat:
            raise InputError(f"{source}: {KEY}.port is missing; a learned law needs it")
        return None
    unit = flat.get(UNIT, own_effort(linear))
    if unit not in EFFORT_UNITS:
        raise InputError(f"{source}: {UNIT} = {unit!r}, expected {', '.join(EFFORT_UNITS)}")
    return counted_in(law, str(unit), linear)


def rigid_law_to_file(law: Law, linear: bool) -> dict[str, Any]:
    """The law as it stands under `effects.learned` in a rigid drive's file."""
    return law_to_file(law) | ({} if law.unit == own_effort(linear) else {"unit": law.unit})


def counted_in(law: Law, unit: str, linear: bool) -> Law:
    """The law with its units: `unit` of effort, and those of the output's motion."""
    end = Units(unit, linear).end
    own = {"position": end, "travel": end, "speed": f"{end}/s", "heat": f"({unit})^2"}
    units = tuple(own.get(name, VARIABLES[name]) for name in law.of)
    return replace(law, effort_unit=unit, variable_units=units)


def scaled(law: Law, factor: float) -> Law:
    """The law with its effort counted otherwise."""
    return replace(law, values=tuple(factor * one for one in law.values))


def packed(law: Law | None) -> NDArray[Any]:
    """One record as `effects.learned` takes it."""
    record = np.zeros(1, dtype=_DTYPE)
    record["rod_per_rotor"] = record["gear_ratio"] = 1.0
    if law is not None:
        learned.put_table(record, law)
        record["learned_port"] = FRICTION if law.of_friction else TORQUE
    return record


def remembered(law: Law | None, motion: Course, effort: FloatArray) -> FloatArray:
    """Heat and travel along a motion, float64[n, 2]; 0 where the law has neither.

    effort: float64[n], without what is above the motion's own band.
    """
    found = np.zeros((motion.time_s.size, 2))
    if law is None:
        return found
    for part in motion.parts:
        if "heat" in law.of:
            known = np.nan_to_num(effort[part])
            found[part, 0] = warmed(known, 1.0 / (motion.rate_hz * law.time_constant_s))
        if "travel" in law.of:
            found[part, 1] = since_reversal(motion.position[part], motion.velocity[part])
    return found


@kernel
def rigid_law(record, time, position, speed, heat, travel):
    """What the law gives; speed: with the sign of the motion that is wanted, at rest as well."""
    return learned.law_value(record, position, speed, 0.0, 0.0, 0.0, time, heat, travel)


@kernel
def _along(records, time, position, speed, memory, out):
    for row in range(out.shape[0]):
        out[row] = rigid_law(
            records[0], time[row], position[row], speed[row], memory[row, 0], memory[row, 1]
        )


def asked(law: Law, motion: Course, sign: FloatArray, effort: FloatArray) -> FloatArray:
    """The effort that the law asks for along a motion, float64[n].

    sign: float64[n] of the speed, as dry friction sees it. effort: see `remembered`.
    """
    made = np.empty(motion.time_s.size)
    memory = remembered(law, motion, effort)
    _along(packed(law), motion.own_s, motion.position, motion.velocity, memory, made)
    found: FloatArray = made * sign if law.of_friction else -made
    return found
