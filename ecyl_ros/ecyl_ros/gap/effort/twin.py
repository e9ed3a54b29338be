"""The closer twin of a rigid drive: the user's drive file with what was found written into it.

Causes go below `effects`, as in the file of a full cylinder; an inertia that the file left out goes
into its own key. The text is kept, and what comes out is read back before it takes its place.
"""

from __future__ import annotations

import dataclasses
import math
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import yaml

from ...drive.drive_file import resolve_drive
from ...errors import InputError
from ..diagnosis import Diagnosis
from ..twin import add_effects, remarks, write_checked
from .acting import Acting, as_file
from .machine import Machine, load_machine
from .units import Units

_DIGITS = 9
_NEAR = 1e-6  # relative: rounding to so many digits, over sums of two


@dataclass(frozen=True, eq=False)
class EffortDiagnosis(Diagnosis):
    """A diagnosis by effort, with the machines that it comes to.

    closest: what comes closest, values fitted to the whole recording; None where no cause is named.
    judged: the machine that the gap after is of, values fitted without the held-out stretches.
    """

    closest: Machine | None = None
    judged: Machine | None = None


def write_effort_twin(diagnosis: Diagnosis, drive: str | os.PathLike[str], out: str | Path) -> None:
    """Write the rigid drive's file `drive` with the causes of `diagnosis` in it to `out`.

    Written whole or not at all.

    Raises:
        InputError: no cause was named, the file cannot be added to without disturbing it, or `out`
            cannot be written.
    """
    machine = diagnosis.closest if isinstance(diagnosis, EffortDiagnosis) else None
    if machine is None or not diagnosis.causes:
        raise InputError(f"{out}: not written, for no cause was named")
    source = resolve_drive(drive)
    nominal = load_machine(source)
    unit = machine.effects_unit or ("N" if machine.linear else "N m")
    effects = {
        name: {key: float(f"{value:.{_DIGITS}g}") for key, value in values.items()}
        for name, values in as_file(
            machine.effects, Units(unit, machine.linear), machine.lead
        ).items()
    }
    text = source.read_bytes().decode("utf-8")
    try:
        changed = add_effects(text, effects, remarks(diagnosis))
        if nominal.inertia is None and machine.inertia is not None:
            key = "load.mass" if machine.linear else "load.inertia"
            value = float(f"{machine.inertia:.{_DIGITS}g}")
            changed = _before_effects(changed, f"{key}: {value!r}")
    except ValueError:
        changed = ""
    write_checked(out, changed, lambda path: _reads_as(path, machine), source, effects)


def _before_effects(text: str, entry: str) -> str:
    """The text with `entry` put before the key `effects` wherever that is a section's."""
    newline = "\r\n" if "\r\n" in text else "\n"
    root = yaml.compose(text, Loader=yaml.SafeLoader)
    places: list[tuple[int, str]] = []

    def visit(node: yaml.Node | None, depth: int) -> None:  # None: an empty file
        if not isinstance(node, yaml.MappingNode) or depth > 2:
            return
        for key, value in node.value:
            if key.value == "effects" and depth == 2:
                between = ", " if node.flow_style else newline + " " * key.start_mark.column
                places.append((key.start_mark.index, entry + between))
            visit(value, depth + 1)

    visit(root, 0)
    for at, new in reversed(places):
        text = text[:at] + new + text[at:]
    return text


def _reads_as(path: Path, wanted: Machine) -> bool:
    """Whether a file holds a machine, but for the rounding of what was written."""
    try:
        found = load_machine(path)
    except InputError:
        return False
    plain = {"effects": (), "effects_unit": None, "inertia": None}
    same = dataclasses.replace(found, **plain) == dataclasses.replace(wanted, **plain)  # type: ignore[arg-type]
    pairs = zip(_ordered(found), _ordered(wanted), strict=False)
    return (
        same
        and _near(found.inertia or 0.0, wanted.inertia or 0.0)
        and len(found.effects) == len(wanted.effects)
        and all(_alike(one, other) for one, other in pairs)
    )


def _ordered(machine: Machine) -> list[Acting]:
    return sorted(machine.effects, key=lambda one: one.name)


def _alike(one: Acting, other: Acting) -> bool:
    return one.name == other.name and _all_near(one.values, other.values)


def _all_near(one: Mapping[str, float], other: Mapping[str, float]) -> bool:
    return one.keys() == other.keys() and all(_near(one[key], other[key]) for key in one)


def _near(one: float, other: float) -> bool:
    return math.isclose(one, other, rel_tol=_NEAR, abs_tol=1e-300)
