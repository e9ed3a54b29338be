"""The text of a library effect that plays a full cylinder's learned law, and of its test.

The law's shape becomes constants of the file, its size the effect's one parameter, so that a
diagnosis can fit it and name it. The words that only an engineer knows are left to fill in.
"""

from __future__ import annotations

from collections.abc import Mapping

from ...drive.law import Law
from .effect_lines import (
    DIRECTION,
    checked,
    constants,
    described,
    looked_up,
    opened,
    sized,
    tested,
)

# The kernels' arguments at each port (`effects.ports`), and what of them a variable is.
_ARGUMENTS = {
    "rotor_torque": "angle, speed, current",
    "rotor_friction": "speed, torque, time",
    "load_torque": "time, angle, speed",
    "load_friction": "speed, torque, angle, time",
    "inverter_voltage": "current, voltage",
    "rotor_angle_error": "angle",
    "current_error": "current",
    "rod_error": "angle",
}
_OF = {
    "position": ("angle", "angle * p.rod_per_rotor"),
    "rotor_angle": ("angle", "angle"),
    "screw_angle": ("angle", "angle / p.gear_ratio"),
    "speed": ("speed", "speed"),
    "direction": ("speed", DIRECTION),
    "current": ("current", "current"),
    "torque": ("torque", "torque"),
    "voltage": ("voltage", "voltage"),
    "time": ("time", "time"),
}
_PEAK = {"N m": "peak_nm", "V": "peak_v", "A": "peak_a", "rad": "peak_rad"}


def _given(law: Law) -> Mapping[str, str]:
    arguments = _ARGUMENTS[law.port].split(", ")
    return {one: text for one, (argument, text) in _OF.items() if argument in arguments}


def effect_text(law: Law, name: str) -> str:
    """The effect's file. Raises InputError, see `effect_lines.checked`."""
    checked(law, name, _given(law))
    size, quantity = sized(law), _PEAK[law.unit]
    side = law.port.split("_")[0]
    signs = (1.0,) if law.of_friction else (1.0, -1.0)
    begun = [f'{{"{quantity}": {sign * size:.6g}}}' for sign in signs]
    lines = opened(law, name)
    if law.of_friction:
        lines += ["from collections.abc import Mapping", ""]
    lines += ["import numpy as np", "", "from ..drive.compiled import kernel"]
    if law.of_friction:
        lines += ["from ..drive.parameters import DriveParameters"]
    imported = "Effect, Evidence, Quantity, Start"
    lines += [
        f"from .effect import {imported}{', bristle, put_bristle' if law.of_friction else ''}"
    ]
    lines += ["from .learned import places, segments"] if law.of else []
    lines += [
        "",
        *constants(law),
        "",
        "",
        "def starts(evidence: Evidence) -> list[Start]:",
        '    """The size that it was learned with, and the other sign."""',
        f"    return [{', '.join(begun)}]",
        "",
        "",
    ]
    if law.of_friction:
        lines += [
            "def modify(record: np.ndarray, values: Mapping[str, float], drive: DriveParameters)"
            " -> None:",
            '    """Let the contact give as the bristle says."""',
            f'    put_bristle(record, "{side}", values)',
            "",
            "",
        ]
    low = 0.0 if law.of_friction else -1e3
    lines += [
        "EFFECT = Effect(",
        *described(law, name),
        "    parameters=(",
        "        Quantity(",
        f'            name="{quantity}",',
        f'            unit="{law.unit}",',
        f"            low={low},",
        "            high=1e3,",
        '            meaning="largest value of the law",',
        "        ),",
        *([f'        *bristle("{side}"),'] if law.of_friction else []),
        "    ),",
        "    starts=starts,",
        *(["    modify=modify,"] if law.of_friction else []),
        "    rarity=2,",
        ")",
    ]
    lines += _kernels(law, name, quantity)
    return "\n".join(lines) + "\n"


def _kernels(law: Law, name: str, quantity: str) -> list[str]:
    field = f"p.{name}_{quantity}"
    value = f"max({field} * value, 0.0)" if law.of_friction else f"{field} * value"
    body = [*looked_up(law, _given(law)), f"    return {value}"]
    signature = _ARGUMENTS[law.port]
    lines = [
        "",
        "",
        "@kernel",
        f"def {law.port}(p, {signature}):",
        f'    """The law{": a level" if law.of_friction else ""}."""',
        f"    if {field} == 0.0:",
        "        return 0.0",
        *body,
    ]
    if law.port == "rotor_angle_error":
        lines += [
            "",
            "",
            "@kernel",
            "def rotor_speed_error(p, angle, speed):",
            '    """The rate of the angle\'s error."""',
            f"    if {field} == 0.0:",
            "        return 0.0",
            "    step = 1e-5",
            "    ahead, here = rotor_angle_error(p, angle + step), rotor_angle_error(p, angle)",
            "    return speed * (ahead - here) / step",
        ]
    return lines


def test_text(law: Law, name: str) -> str:
    """The effect's test: it plays what the learned law plays.

    Raises InputError, see `effect_lines.checked`.
    """
    checked(law, name, _given(law))
    quantity, size = _PEAK[law.unit], sized(law)
    return f'''"""{name.replace("_", " ").capitalize()}, against the law it was made of."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from ecyl_ros.drive.drive_file import load_drive
from ecyl_ros.drive.engine import simulate
from ecyl_ros.drive.law import law_from_flat

{tested(law)}

def _reference(index: int) -> tuple[float, float]:
    """5 mm to and fro at 1 Hz."""
    angle = 2e-3 * math.pi * index
    return 5e-3 * math.sin(angle), 5e-3 * 2.0 * math.pi * math.cos(angle)


def test_it_plays_what_was_learned():
    """The drive moves with the effect as it moves with the learned law."""
    drive = load_drive("bench")
    law = law_from_flat(LAW, "test")
    learned = simulate(dataclasses.replace(drive, learned=law), _reference, 1.0)
    values = {{"{name}": {{"{quantity}": {size!r}}}}}
    named = simulate(dataclasses.replace(drive, effects=values), _reference, 1.0)
    moved = simulate(drive, _reference, 1.0)
    off = np.abs(learned.samples - moved.samples).max(axis=0)
    apart = np.abs(learned.samples - named.samples).max(axis=0)
    assert off.max() > 0.0
    assert np.all(apart <= 1e-3 * off + 1e-12)
'''
