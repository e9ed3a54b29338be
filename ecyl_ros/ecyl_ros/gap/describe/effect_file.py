"""The text of a library effect that plays a learned law, and of its test.

The law's shape becomes constants of the file, its size the effect's one parameter, so that a
diagnosis can fit it and name it. The words that only an engineer knows are left to fill in.
"""

from __future__ import annotations

import re

import numpy as np

from ...drive.law import Law, law_to_flat
from ...effects.catalogue import EFFECTS
from ...errors import InputError
from . import words

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
    "direction": ("speed", "1.0 if speed > 0.0 else (-1.0 if speed < 0.0 else 0.0)"),
    "current": ("current", "current"),
    "torque": ("torque", "torque"),
    "voltage": ("voltage", "voltage"),
    "time": ("time", "time"),
}
_PEAK = {"N m": "peak_nm", "V": "peak_v", "A": "peak_a", "rad": "peak_rad"}
_NAME = re.compile(r"[a-z][a-z0-9_]*")


def checked(law: Law, name: str) -> None:
    """Raises InputError where no effect of this name can play the law."""
    if not _NAME.fullmatch(name):
        raise InputError(f"--name {name}: expected small letters, digits and _, a letter first")
    if name in EFFECTS or name == "learned":
        raise InputError(f"--name {name}: there is such an effect; expected a new name")
    given = _ARGUMENTS[law.port].split(", ")
    for one in law.of:
        if one not in _OF or _OF[one][0] not in given:
            raise InputError(
                f"effects.learned.of = {one}: an effect at {law.port} is not given it; expected a "
                f"law of {', '.join(k for k, v in _OF.items() if v[0] in given)}"
            )


def effect_text(law: Law, name: str) -> str:
    """The effect's file. Raises InputError, see `checked`."""
    checked(law, name)
    size, quantity = _sized(law), _PEAK[law.unit]
    shape = np.array(law.values) / size
    block = words.BLOCKS[law.port]
    title = name.replace("_", " ")
    said = f"{words.place(law)} {words.depends(law)}"
    said = said[:1].upper() + said[1:]
    side = law.port.split("_")[0]
    signs = (1.0,) if law.of_friction else (1.0, -1.0)
    begun = [f'{{"{quantity}": {sign * size:.6g}}}' for sign in signs]
    lines = [
        f'"""{title.capitalize()}: {said[:1].lower()}{said[1:]}."""',
        "",
        "from __future__ import annotations",
        "",
    ]
    if law.of_friction:
        lines += ["from collections.abc import Mapping", ""]
    lines += ["import numpy as np", "", "from ..drive.compiled import kernel"]
    if law.of_friction:
        lines += ["from ..drive.parameters import DriveParameters"]
    imported = "Effect, Evidence, Quantity, Start"
    lines += [
        f"from .effect import {imported}{', bristle, put_bristle' if law.of_friction else ''}"
    ]
    lines += ["from .learned import places"] if law.of else []
    lines += ["", "# As it was learned; its largest value is 1."]
    for number, one in enumerate(law.at):
        lines.append(f"_AT_{number + 1} = np.array({_numbers(one)})")
    lines.append(f"_SHAPE = np.array({_numbers(shape)})")
    lines += [
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
        f'    name="{name}",',
        f'    block="{block}",',
        f'    title="{title}",  # FILL IN: what a drive engineer calls it',
        f'    summary="{said}.",  # FILL IN: what it is',
        '    excitation="motion over what the law was learned on",  # FILL IN',
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
    if not law.of:
        body = [f"    return {field} * _SHAPE[0]"]
    else:
        body = []
        for number, (one, places, period) in enumerate(
            zip(law.of, law.at, law.periods, strict=True), 1
        ):
            body.append(f"    x = {_OF[one][1]}")
            body.append(f"    at_{number} = places(_AT_{number}, {len(places)}, {period!r}, x)")
        if len(law.of) == 1:
            terms = [f"at_1[{k + 4}] * _SHAPE[at_1[{k}]]" for k in range(4)]
        else:
            width = len(law.at[1])
            terms = [
                f"at_1[{j + 4}] * at_2[{k + 4}] * _SHAPE[at_1[{j}] * {width} + at_2[{k}]]"
                for j in range(4)
                for k in range(4)
            ]
        body.append("    value = " + terms[0])
        body += [f"    value += {one}" for one in terms[1:]]
        body.append(f"    return {field} * value")
        if law.of_friction:
            body[-1] = f"    return max({field} * value, 0.0)"
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
    """The effect's test: it plays what the learned law plays. Raises InputError, see `checked`."""
    checked(law, name)
    quantity, size = _PEAK[law.unit], _sized(law)
    flat = law_to_flat(law)
    entries = ",\n    ".join(f"{key!r}: {_entry(value)}" for key, value in flat.items())
    return f'''"""{name.replace("_", " ").capitalize()}, against the law it was made of."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from ecyl_ros.drive.drive_file import load_drive
from ecyl_ros.drive.engine import simulate
from ecyl_ros.drive.law import law_from_flat

LAW = {{
    {entries},
}}


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


def _sized(law: Law) -> float:
    """The law's largest value, or 1 where it is 0 throughout."""
    return float(np.max(np.abs(law.values))) or 1.0


def _numbers(values: object) -> str:
    """Numbers of a list, a few on each line."""
    texts = [f"{float(one):.9g}" for one in np.asarray(values)]
    texts = [one if any(c in one for c in ".en") else f"{one}.0" for one in texts]
    if len(texts) <= 4:
        return f"[{', '.join(texts)}]"
    rows = [", ".join(texts[k : k + 6]) for k in range(0, len(texts), 6)]
    return "[\n    " + ",\n    ".join(rows) + ",\n]"


def _entry(value: object) -> str:
    if isinstance(value, list) and value and isinstance(value[0], float):
        rows = [", ".join(repr(v) for v in value[k : k + 4]) for k in range(0, len(value), 4)]
        return "[\n        " + ",\n        ".join(rows) + ",\n    ]"
    return repr(value).replace("'", '"')
