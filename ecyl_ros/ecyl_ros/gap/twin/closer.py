"""The twin: the user's drive file with the constants that were found, and the causes.

The file's text is kept, comments and order included: found constants take the place of the nominal
ones, causes are put in under `effects`; an inertia that the file of a rigid drive left out goes
into its own key. What comes out is read back before it takes its place: it must be the nominal
drive with these, nothing else.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from ...drive.drive_file import drive_to_flat, resolve_drive
from ...drive.law import law_to_file, rounded
from ...drive.model_file import load_model
from ...drive.parameters import DriveParameters
from ...drive.rigid.effects_file import as_file
from ...drive.rigid.law import rigid_law_to_file
from ...drive.rigid.machine import KEYS, Machine, same_machine
from ...drive.rigid.units import Units, own_effort
from ...drive.tolerances import ALL, with_constants
from ...effects.catalogue import CATALOGUE
from ...errors import InputError
from ...recording.atomic import replacing
from ..diagnosis import Diagnosis
from ..rigid.closest import WRITTEN
from .drive_text import Effects, add_effects, add_values, holds, with_values

_DIGITS = 9


def write_twin(diagnosis: Diagnosis, drive: str | os.PathLike[str], out: str | Path) -> None:
    """Write the drive file (or profile) `drive` with what the diagnosis found to `out`.

    Written whole or not at all. An effect that the file has already gets the values found.

    Raises:
        InputError: nothing was found, the file cannot be changed without disturbing it, or `out`
            cannot be written.
    """
    source = resolve_drive(drive)
    nominal = load_model(source)
    if not diagnosis.has_twin:
        raise InputError(f"{out}: not written, for no cause was named")
    text = source.read_bytes().decode("utf-8")
    if isinstance(nominal, Machine):
        # One tolerance of all constants leaves no room for that of a single one.
        single = holds(text, f"tolerances.{ALL}") or ALL not in nominal.tolerances
        twin = _rigid(diagnosis, nominal, with_tolerance=single)
    else:
        twin = _full(diagnosis, nominal)
    try:
        changed = twin.written(text)
    except ValueError:
        changed = ""
    with replacing(out) as temporary:
        temporary.write_bytes(changed.encode("utf-8"))
        if not (changed and _reads_as(temporary, twin.is_meant)):
            keys = ", ".join(f"effects.{name}" for name in twin.effects)
            raise InputError(
                f"{source}: laid out in a way that {keys} cannot be added to; expected one block "
                "of parameters below '/**: ros__parameters:'"
            )


@dataclass(frozen=True)
class _Twin:
    """What is to be written.

    effects: what is put under `effects`, by name. written: the changed text, ValueError where it
    cannot be.
    is_meant: whether a drive is what the file should hold.
    """

    effects: Mapping[str, Mapping[str, Any]]
    written: Callable[[str], str]
    is_meant: Callable[[DriveParameters | Machine], bool]


def _reads_as(path: Path, is_meant: Callable[[DriveParameters | Machine], bool]) -> bool:
    try:
        return is_meant(load_model(path))
    except InputError:
        return False


def _full(diagnosis: Diagnosis, nominal: DriveParameters) -> _Twin:
    effects = {one.effect: _rounded(one.effect, diagnosis) for one in diagnosis.causes}
    constants, lead = _constants(diagnosis, nominal)
    notes = _remarks(diagnosis)
    if lead is not None:
        effects["lead_error"] = {"lead_m": lead}
        notes["lead_error"] = "within its tolerance; the controller still uses the sheet"
    law = nominal.learned if diagnosis.law is None else rounded(diagnosis.law.law, _digits)
    wanted = _added(replace(with_constants(nominal, constants), learned=law), effects)
    entries: dict[str, Mapping[str, Any]] = dict(effects)
    if law is not None and diagnosis.law is not None:
        entries["learned"] = law_to_file(law)

    def written(text: str) -> str:
        values = _as_written(nominal, constants)
        new = {key: values.pop(key) for key in constants if not holds(text, key)}
        text = add_values(with_values(text, values), new)
        return add_effects(text, entries, notes) if entries else text

    def is_meant(found: DriveParameters | Machine) -> bool:
        return isinstance(found, DriveParameters) and drive_to_flat(found) == wanted

    return _Twin(entries, written, is_meant)


def _rigid(diagnosis: Diagnosis, nominal: Machine, *, with_tolerance: bool) -> _Twin:
    machine = diagnosis.closest
    assert machine is not None  # where something was found
    key = "load.mass" if machine.linear else "load.inertia"
    if nominal.inertia is None and machine.inertia is not None:
        possible = KEYS[key]
        if not possible.low <= _digits(machine.inertia) <= possible.high:
            machine = replace(machine, inertia=None)  # not seen here: as unknown as before
    fresh: dict[str, float] = {}
    if nominal.inertia is None and machine.inertia is not None:
        fresh[key] = _digits(machine.inertia)
        share = _known_to(diagnosis, machine.inertia)
        told = nominal.tolerances
        if with_tolerance and share is not None and key not in told:
            fresh[f"tolerances.{key}"] = share
            machine = replace(machine, tolerances={**told, key: share})
    units = Units(machine.effects_unit or own_effort(machine.linear), machine.linear)
    effects: dict[str, Mapping[str, Any]] = {
        name: {key: _digits(value) for key, value in values.items()}
        for name, values in as_file(machine.effects, units, machine.lead).items()
    }
    if diagnosis.law is not None and machine.learned is not None:
        law = rounded(machine.learned, _digits)
        machine = replace(machine, learned=law)
        effects["learned"] = rigid_law_to_file(law, machine.linear)

    other = "load.inertia" if machine.linear else "load.mass"
    constants = {
        one: _digits(getattr(machine, KEYS[one].field))
        for one in WRITTEN
        if getattr(nominal, KEYS[one].field) is not None
        and one != other
        and getattr(machine, KEYS[one].field) != getattr(nominal, KEYS[one].field)
    }

    def written(text: str) -> str:
        text = add_values(with_values(text, dict(constants)), fresh)
        return add_effects(text, effects, _remarks(diagnosis)) if effects else text

    def is_meant(found: DriveParameters | Machine) -> bool:
        return isinstance(found, Machine) and same_machine(found, machine)

    return _Twin(effects, written, is_meant)


def _known_to(diagnosis: Diagnosis, inertia: float) -> float | None:
    """The share of an inertia that holds its 95 % interval; None where that was not measured."""
    names = ("mass_kg", "inertia_kg_m2")
    found = next((one for one in diagnosis.measured if one.name in names), None)
    if found is None or not inertia > 0.0:
        return None
    share = max(found.high - inertia, inertia - found.low) / inertia
    return math.ceil(100.0 * share) / 100.0 if 0.0 < share <= 1.0 else None


def _constants(
    diagnosis: Diagnosis, drive: DriveParameters
) -> tuple[dict[str, float], float | None]:
    """Found constants by key, and the lead if it was found off the sheet.

    The controller turns its reference into a rotor angle by the sheet's lead and gear ratio, which
    must therefore stay in the file.
    """
    found = {
        one.parameter: _digits(one.value) for one in diagnosis.sheet if one.value != one.nominal
    }
    lead = found.pop("transmission.lead", drive.transmission.lead)
    ratio = found.pop("transmission.gear_ratio", drive.transmission.gear_ratio)
    lead *= drive.transmission.gear_ratio / ratio
    return found, None if lead == drive.transmission.lead else _digits(lead)


def _as_written(
    drive: DriveParameters, constants: Mapping[str, float]
) -> dict[str, float | list[float]]:
    """Constants as the file holds them: every segment of a piecewise stiffness."""
    changed = with_constants(drive, constants)
    found: dict[str, float | list[float]] = dict(constants)
    if "transmission.stiffness" in found:
        found["transmission.stiffness"] = list(changed.transmission.stiffness)
    return found


def _rounded(effect: str, diagnosis: Diagnosis) -> dict[str, float]:
    quantities = {one.name: one for one in CATALOGUE[effect].parameters}
    found = {}
    for name, value in diagnosis.values[effect].items():
        rounded = _digits(value)
        found[name] = min(max(rounded, quantities[name].low), quantities[name].high)
    return found


def _added(drive: DriveParameters, effects: Effects) -> dict[str, object]:
    flat = {
        key: value
        for key, value in drive_to_flat(drive).items()
        if not any(key.startswith(f"effects.{name}.") for name in effects)
    }
    for name, values in effects.items():
        full = CATALOGUE[name].complete(values)
        flat |= {f"effects.{name}.{parameter}": value for parameter, value in full.items()}
    return flat


def _digits(value: float) -> float:
    """As it is written."""
    return float(f"{value:.{_DIGITS}g}")


def _remarks(diagnosis: Diagnosis) -> dict[str, str]:
    """Comments by effect and by "effect.parameter"; "" stands for all."""
    name = _printable(diagnosis.name)
    found = {"": f"Added by ecyl diagnose: what {name} shows beyond the model above."}
    if diagnosis.law is not None:
        found["learned"] = f"{diagnosis.law.words}; it has no name yet"
    for cause in diagnosis.causes:
        found[cause.effect] = f"{cause.title}, confidence {min(cause.confidence, 0.99):.2f}"
        for one in cause.parameters:
            unit = "" if one.unit == "1" else f"{one.unit}, "
            found[f"{cause.effect}.{one.name}"] = f"{unit}95 %: {one.low:.6g} to {one.high:.6g}"
    return found


def _printable(text: str) -> str:
    return "".join(c if c.isprintable() else "?" for c in text)
