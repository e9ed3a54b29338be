"""Drive files of rigid drives (`drive.kind: rigid`) and of followers (`drive.kind: follower`).

They are ROS 2 parameter files like those of a full cylinder, with fewer keys. What is unknown is
left out; the diagnosis then says what that costs.
"""

from __future__ import annotations

import dataclasses
import difflib
import os
from collections.abc import Mapping
from typing import Any

from ...errors import InputError
from ...finite import is_finite
from ..drive_file import NODE_KEYS, read_parameter_file, resolve_drive
from ..law import KEY
from ..tolerances import RIGID, stated_tolerances
from .effects_file import effects_table, parse
from .law import UNIT, law_of
from .machine import KEYS, OUTPUTS, Key, Machine


def load_machine(path: str | os.PathLike[str]) -> Machine:
    """Read and check the drive file of a rigid drive or a follower.

    Raises:
        InputError: unreadable, a key of another name, a value of another kind or range, or keys
            that do not go together.
    """
    source = resolve_drive(path)
    return machine_from_flat(read_parameter_file(source), str(source))


def machine_from_flat(flat: Mapping[str, Any], source: str) -> Machine:
    """`Machine` from dotted parameters; see `load_machine`."""
    acting, law_keys = {}, {}
    known = ", ".join((*KEYS, "effects", "tolerances"))
    for key in flat:
        if key in KEYS or key.split(".")[0] in ("tolerances", *NODE_KEYS):
            continue
        if key == KEY or key.startswith(f"{KEY}."):
            law_keys[key] = flat[key]
            continue
        if key.startswith("effects.") and key.count(".") == 2:
            acting[key.removeprefix("effects.")] = flat[key]
            continue
        near = difflib.get_close_matches(key, KEYS, n=1)
        hint = f"did you mean {near[0]}?" if near else f"a rigid drive has {known}"
        raise InputError(f"{source}: unknown key {key}; {hint}")
    values: dict[str, Any] = {}
    for key in ("drive.kind", "drive.output"):
        if key not in flat:
            raise InputError(
                f"{source}: {key} is missing; expected {' or '.join(KEYS[key].choices)}"
            )
    for key, one in KEYS.items():
        if key in flat:
            values[one.field] = _value(flat[key], one, key, str(flat["drive.output"]), source)
    linear = values["output"] == "linear"
    units = {key: KEYS[key].units[not linear] for key in RIGID}
    stated = stated_tolerances(flat, units, source, RIGID)
    effects, unit = parse(acting, linear, values.get("lead"), source)
    learned = law_of(law_keys, linear, source)
    if learned is not None and unit not in (None, learned.unit):
        raise InputError(
            f"{source}: {UNIT} = {learned.unit!r}, expected {unit!r}, in which the other effects "
            "are counted"
        )
    machine = Machine(
        **values,
        tolerances=stated,
        effects=effects,
        effects_unit=unit if learned is None else learned.unit,
        learned=learned,
    )
    _check_relations(machine, source)
    return _with_own_gain(machine)


def _value(value: Any, key: Key, name: str, output: str, source: str) -> Any:
    if key.choices:
        if value not in key.choices:
            raise InputError(f"{source}: {name} = {value!r}, expected {' or '.join(key.choices)}")
        return value
    if output in OUTPUTS and output not in key.outputs:
        other = "load.inertia" if name == "load.mass" else "load.mass"
        hint = f"; expected {other}" if name.startswith("load") else ""
        raise InputError(f"{source}: {name} does not go with drive.output {output}{hint}")
    unit = key.units[output == "rotary"]
    above = "above" if key.open_low else "from"
    wanted = f"expected a number {above} {key.low:g} to {key.high:g} {unit}"
    if isinstance(value, str):  # YAML 1.1 reads 1e3 (no dot) as text; ROS reads a number
        try:
            value = float(value)
        except ValueError:
            raise InputError(f"{source}: {name} = {value!r}, {wanted}") from None
    if not is_finite(value):
        raise InputError(f"{source}: {name} = {value!r}, {wanted}")
    if not key.low <= value <= key.high or (key.open_low and value == key.low):
        raise InputError(f"{source}: {name} = {value:g}, {wanted} (SI units throughout)")
    return float(value)


def _check_relations(machine: Machine, source: str) -> None:
    if machine.actuation == "force" and not machine.linear:
        raise InputError(
            f"{source}: actuation.signal = 'force' does not go with drive.output rotary; expected "
            "torque, current, voltage or loop"
        )
    if (machine.effects or machine.learned) and machine.kind == "follower":
        raise InputError(f"{source}: effects do not go with drive.kind follower; expected rigid")
    if machine.actuation == "loop" and not machine.loop_known:
        raise InputError(
            f"{source}: controller.speed.kp is missing; actuation.signal = 'loop' computes the "
            "effort with it"
        )
    for name, given in (
        ("controller.position.kp", machine.position_kp),
        ("controller.speed.ki", machine.speed_ki or None),
    ):
        if given is not None and not machine.loop_known:
            raise InputError(f"{source}: controller.speed.kp is missing; {name} needs it")


def _with_own_gain(machine: Machine) -> Machine:
    """Force of a linear and torque of a rotary output are effort as they are."""
    own = "force" if machine.linear else "torque"
    if machine.actuation == own and machine.gain is None:
        return dataclasses.replace(machine, gain=1.0)
    return machine


def key_table() -> str:
    """Every key as a table of Markdown, for docs/drive-file.md."""
    rows = [
        "| key | unit (linear, rotary) | possible | meaning |",
        "|---|---|---|---|",
    ]
    for name, one in KEYS.items():
        unit = ", ".join(dict.fromkeys(unit for unit in one.units if unit))
        possible = " or ".join(one.choices)
        if not possible:
            possible = f"above {one.low:g}" if one.open_low else f"{one.low:g} to {one.high:g}"
        rows.append(f"| `{name}` | {unit} | {possible} | {one.meaning} |")
    return "\n".join(rows)


if __name__ == "__main__":
    print(key_table(), effects_table(), sep="\n\n")
