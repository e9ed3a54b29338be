"""The text of a library effect that plays a rigid drive's learned law, and of its test.

As `effect_file` does it for a full cylinder: the law's shape becomes constants of the file, its
size the coefficient that a diagnosis fits.
"""

from __future__ import annotations

from collections.abc import Mapping

from ...drive.law import Law
from ...drive.rigid.units import own_effort
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

# What the kernels of `effects.rigid_ports` are given of a law's variables: a load, a friction.
_LOAD = {"position": "position", "rotor_angle": "position", "time": "time"}
_LEVEL = {
    **_LOAD,
    "speed": "speed",
    "direction": DIRECTION,
}


def _given(law: Law) -> Mapping[str, str]:
    return _LEVEL if law.of_friction else _LOAD


def rigid_effect_text(law: Law, name: str, linear: bool) -> str:
    """The effect's file; linear: whether the drive's output is. Raises InputError, see
    `effect_lines.checked`."""
    checked(law, name, _given(law))
    value = "max(value, 0.0)" if law.of_friction else "value"
    column = "along.sign * made" if law.of_friction else "-made"
    lines = [
        *opened(law, name),
        *([] if law.of_friction else ["import math", ""]),
        "import numpy as np",
        "",
        "from ..drive.compiled import kernel",
        "from .along import Along",
        "from .effect import Effect",
        *(["from .learned import places, segments"] if law.of else []),
        "from .rigid_form import RigidForm, level",
        "from .term import Term",
        "",
        *constants(law),
        "",
        "EFFECT = Effect(",
        *described(law, name),
        "    parameters=(),",
        "    rarity=2,",
        "    cylinder=False,  # learned from a drive of one inertia",
        ")",
        "",
        "",
        "@kernel",
        "def _shape(time, position, speed):",
        '    """The law over its largest value."""',
        *looked_up(law, _given(law)),
        f"    return {value}",
        "",
        "",
        "@kernel",
        "def _along(time, position, speed, out):",
        "    for row in range(out.shape[0]):",
        "        out[row] = _shape(time[row], position[row], speed[row])",
        "",
        "",
        "def term(along: Along) -> Term:",
        '    """What the law asks for along a motion."""',
        "    units, motion = along.units, along.motion",
        "    made = np.empty(motion.time_s.size)",
        "    _along(motion.own_s, motion.position, motion.velocity, made)",
        "    return Term(",
        f'        effect="{name}",',
        f'        key="{name}",',
        f"        columns=({column})[None],",
        '        parameters=lambda c: ((units.level("peak"), units.effort, float(c[0])),),',
        '        values=lambda c: {"peak": float(c[0])},',
        f"        low=({'0.0' if law.of_friction else '-math.inf'},),",
        "    )",
        "",
        "",
        "RIGID = RigidForm(",
        f'    outputs=("{"linear" if linear else "rotary"}",),',
        '    stems=(level("peak", "largest value of the law"),),',
        "    term=term,",
        '    coefficients=lambda values: (values["peak"],),',
        ")",
        "",
        "",
        "@kernel",
    ]
    if law.of_friction:
        lines += [
            "def rigid_level(v, time, position, speed, acceleration):",
            '    """The law as a level; v: its largest value."""',
            "    return v[0] * _shape(time, position, speed)",
        ]
    else:
        lines += [
            "def rigid_load(v, time, position):",
            '    """The law, which drives where it is positive; v: its largest value."""',
            "    return -v[0] * _shape(time, position, 0.0)",
        ]
    return "\n".join(lines) + "\n"


def rigid_test_text(law: Law, name: str, linear: bool) -> str:
    """The effect's test: it asks for and plays what the learned law does.

    linear: whether the drive's output is. Raises InputError, see `effect_lines.checked`.
    """
    checked(law, name, _given(law))
    kind = 'output="linear"' if linear else 'output="rotary"'
    actuation, effort = ("force", "rod_force_n") if linear else ("torque", "rotor_torque_nm")
    position = "rod_position_m" if linear else "rotor_position_rad"
    middle, reach = _stroke(law)
    return f'''"""{name.replace("_", " ").capitalize()}, against the law it was made of."""

from __future__ import annotations

import dataclasses

import numpy as np

from ecyl_ros.drive.rigid.driven import Pieces, by_effort
from ecyl_ros.drive.rigid.law import law_of
from ecyl_ros.drive.rigid.machine import Machine
from ecyl_ros.drive.rigid.model import Acting
from ecyl_ros.gap.rigid.motion import motion_of
from ecyl_ros.gap.rigid.terms import Catalogue
from ecyl_ros.recording.signals import Recording

{tested(law)}
MACHINE = Machine(
    kind="rigid",
    {kind},
    actuation="{actuation}",
    inertia=1.0,
    effects_unit="{own_effort(linear)}",
)


def test_it_asks_for_what_was_learned():
    """Along a motion the effect asks for what the law does, and moves the drive as the law does."""
    time = np.arange(8000) * 1e-3
    place = {middle!r} + {reach!r} * np.sin(2.0 * np.pi * 0.4 * time)
    recording = Recording(
        stamp_ns=(1e9 * time).astype(np.int64),
        {position}=place,
        {effort}=np.gradient(place),
    )
    motion = motion_of(recording, MACHINE, "test")
    law = law_of(LAW, {linear}, "test")
    learned = dataclasses.replace(MACHINE, learned=law)
    named = dataclasses.replace(MACHINE, effects=(Acting("{name}", {{"peak": {sized(law)!r}}}),))
    whole = Pieces(np.array([0]), np.array([time.size]))

    def made(machine):
        asked = Catalogue(motion, machine).nominal()
        return asked, by_effort(motion, machine, True, whole, np.zeros(time.size)).velocity

    for plain, by_law, by_name in zip(made(MACHINE), made(learned), made(named), strict=True):
        off = np.abs(by_law - plain).max()
        assert off > 0.0
        assert np.abs(by_name - by_law).max() <= 1e-6 * off
'''


def _stroke(law: Law) -> tuple[float, float]:
    """Middle and half width of a motion over the law's places."""
    for one, at in zip(law.of, law.at, strict=True):
        if one in ("position", "rotor_angle"):
            return 0.5 * (at[0] + at[-1]), 0.5 * (at[-1] - at[0])
    return 0.0, 0.1
