"""The machine that comes closest to a recording: the drive file's with what was found added."""

from __future__ import annotations

import dataclasses

from ...drive.rigid.acting import Acting
from ...drive.rigid.machine import Machine
from ...drive.rigid.model import gain_ratio
from .balance import Solution
from .terms import Catalogue

_ADDING = ("viscous_friction", "coulomb_friction", "constant_load", "direction_dependent_friction")


def closest(catalogue: Catalogue, solution: Solution) -> Machine:
    """The catalogue's machine with the terms of `solution` and their coefficients added.

    Its nominal effort is what `solution` explains, but for a delay, which a fit knows to first
    order only.
    """
    machine = catalogue.machine
    found = list(machine.effects)
    for term in solution.terms:
        values = term.values(solution.of(term))
        if term.key == "inertia" and machine.inertia is None and catalogue.units.own:
            machine = dataclasses.replace(machine, inertia=values["inertia"])
        else:
            _add(found, Acting(term.effect, values), machine, catalogue.model.keys[0])
    unit = catalogue.units.effort if found else machine.effects_unit
    return dataclasses.replace(machine, effects=tuple(found), effects_unit=unit)


def _add(found: list[Acting], new: Acting, machine: Machine, inertia: float) -> None:
    """Add to the effects of one name where two of it come to one, else beside them."""
    at = next((at for at, one in enumerate(found) if one.name == new.name), None)
    old = found[at].values if at is not None else {}
    values = dict(new.values)
    if new.name.endswith("_inertia_error"):
        values = {"inertia": old.get("inertia", inertia) + values["inertia"]}
    elif new.name == "torque_constant_error":
        stem = "per_volt" if machine.actuation == "voltage" else "per_ampere"
        values = {stem: (machine.gain or 1.0) / (gain_ratio(machine) + values["ratio"])}
    elif new.name == "actuation_delay" or new.name.endswith(_ADDING):
        values = {name: old.get(name, 0.0) + value for name, value in values.items()}
    elif new.name == "load_dependent_friction" and values.keys() == old.keys():
        values = {name: old[name] + value for name, value in values.items()}
    else:
        at = None
    made = Acting(new.name, values)
    if at is None:
        found.append(made)
    else:
        found[at] = made
