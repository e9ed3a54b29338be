"""The machine that comes closest to a recording: the drive file's with what was found added."""

from __future__ import annotations

import dataclasses
from collections.abc import Collection
from typing import Any

import numpy as np

from ...drive.rigid.machine import KEYS, Machine
from ...drive.rigid.model import Acting
from ...effects.along import Along
from ...effects.catalogue import RIGID
from ...effects.term import Term
from .solution import Solution

# Keys whose constants are written in their own place; another gain would count all others again.
WRITTEN = (
    "load.mass",
    "load.inertia",
    "load.viscous_friction",
    "load.coulomb_friction",
    "load.constant_load",
)

_SAME_GAIN = 1e-6  # of a coefficient, which is a share of the gain


def closest(along: Along, solution: Solution, without: Collection[Term] = ()) -> Machine:
    """The nominal machine with the terms of `solution` and their coefficients added.

    without: terms that stay out of it.

    Its nominal effort is what `solution` explains, but for a delay, which a fit knows to first
    order only.
    """
    machine = along.machine
    found = list(machine.effects)
    ratio, counted = solution.ratio(along.model), per_effort(along, solution)
    for term in solution.terms:
        coefficients = solution.of(term)
        values = term.values(coefficients * counted if term.of_effort else coefficients)
        key = RIGID[term.effect].constant[not machine.linear]
        if term.key == "gain" and np.abs(coefficients).max() < _SAME_GAIN:
            continue  # of the file, as it stands there
        if solution.known(term) and not key:  # of the recording, not of the machine
            continue
        if any(term is one for one in without):
            continue
        if solution.known(term) and key in WRITTEN:  # a constant, off its nominal value
            (value,) = term.values(coefficients).values()
            nominal = getattr(machine, KEYS[key].field)
            moved: dict[str, Any] = {KEYS[key].field: nominal + value / ratio}
            machine = dataclasses.replace(machine, **moved)
        elif along.units.own and key and getattr(machine, KEYS[key].field) is None:
            (value,) = values.values()  # the file left it out: it goes into its own key
            given: dict[str, Any] = {KEYS[key].field: value}
            machine = dataclasses.replace(machine, **given)
        else:
            _add(found, Acting(term.effect, values), along)
    unit = along.units.effort if found else machine.effects_unit
    return dataclasses.replace(machine, effects=tuple(found), effects_unit=unit)


def per_effort(along: Along, solution: Solution) -> float:
    """By what effort has to be multiplied as a file counts it: in N or N m, whatever the gain comes
    to; 1 where it is not known in these."""
    ratio = solution.ratio(along.model)
    return 1.0 / ratio if along.units.own and ratio > 0.0 else 1.0


def _add(found: list[Acting], new: Acting, along: Along) -> None:
    """Add to the effects of one name where two of it come to one, else beside them."""
    at = next((at for at, one in enumerate(found) if one.name == new.name), None)
    old = {} if at is None else found[at].values
    merged = RIGID[new.name].merged(old, new.values, along)
    if merged is not None and at is not None:
        found[at] = Acting(new.name, merged)
    else:
        found.append(new if merged is None else Acting(new.name, merged))
