"""What a rigid drive's file comes to: one model of effort, and that packed for the step.

`Machine` is what people and files see; each effect says for itself what it changes.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray
from ...effects.catalogue import RIGID
from ...effects.rigid_form import EFFORT_KINDS
from ...effects.rigid_ports import KINDS, PORTS, port_of
from . import law
from .machine import Machine
from .model import Acting, Keys, Model


def model_of(machine: Machine, own: bool) -> Model:
    """The model of `machine`.

    own: whether effort is counted in N or N m of the output. Where it is not, the gain is unknown,
    and what the file's keys ask for with it, unless an effect tells it.
    """
    keys = Keys(
        machine.inertia or 0.0,
        machine.viscous,
        machine.coulomb,
        machine.constant,
        machine.stiffness,
    )
    ratio = _gain_ratio(machine, own)
    inertia, viscous, coulomb, constant, stiffness = (ratio * one for one in keys)
    made = Model(
        inertia=inertia if ratio and machine.inertia is not None else None,
        viscous=(viscous, viscous),
        coulomb=(coulomb, coulomb),
        constant=constant,
        stiffness=stiffness,
        delay_s=0.0,
        keys=keys,
        ratio=ratio,
        counted=1.0 if own else ratio,
    )
    factor = made.ratio / (made.counted or 1.0)
    effects = [scaled(one, factor) for one in machine.effects]
    shapes = tuple(one for one in effects if RIGID[one.name].modify is None)
    made = replace(made, shapes=shapes)
    if machine.learned is not None:
        made = replace(made, learned=law.scaled(machine.learned, factor or 1.0))
    for one in effects:
        modify = RIGID[one.name].modify
        if modify is not None:
            made = modify(made, one.values)
    return made


def scaled(effect: Acting, factor: float) -> Acting:
    """An effect whose efforts are counted otherwise: `factor` for one of those it has."""
    if factor in (0.0, 1.0):
        return effect
    efforts = {one.name for one in RIGID[effect.name].stems if one.kind in EFFORT_KINDS}
    values = {
        name: value * factor if name in efforts else value for name, value in effect.values.items()
    }
    return Acting(effect.name, values)


def _gain_ratio(machine: Machine, own: bool) -> float:
    """Effort by the file's gain over effort by the true one, which an effect may tell.

    Without a gain in the file, effort as recorded over the output's own; 0 where nothing tells it.
    """
    for one in machine.effects:
        ratio = RIGID[one.name].ratio
        if ratio is not None:
            return ratio(one.values, machine.gain or 1.0)
    return 1.0 if own else 0.0


class Plant(NamedTuple):
    """A `Model` packed for the step; all in the balance's unit.

    loads, levels, shares: float64[k, 1 + values], a row an effect at its port: its kind (see
    `effects.rigid_ports`), then what its kernel takes. law: one record (see `rigid.law`).
    """

    inertia: float
    viscous_forwards: float
    viscous_backwards: float
    coulomb_forwards: float
    coulomb_backwards: float
    constant: float
    stiffness: float
    loads: FloatArray
    levels: FloatArray
    shares: FloatArray
    law: NDArray[Any]


def plant_of(model: Model) -> Plant:
    """Pack a model whose inertia is known."""
    assert model.inertia is not None
    rows: dict[str, list[list[float]]] = {port: [] for port in PORTS}
    for one in model.shapes:
        form = RIGID[one.name]
        if form.packed is not None:
            values = list(form.packed(one.values, model))
        else:
            values = [one.values[stem.name] for stem in form.stems]
        port = port_of(one.name)
        assert port is not None, one.name
        rows[port].append([float(KINDS[one.name]), *values])
    loads, levels, shares = (_table(rows[port]) for port in PORTS)
    return Plant(
        model.inertia,
        *model.viscous,
        *model.coulomb,
        model.constant,
        model.stiffness,
        loads,
        levels,
        shares,
        law.packed(model.learned),
    )


def _table(rows: list[list[float]]) -> FloatArray:
    made = np.zeros((len(rows), max((len(row) for row in rows), default=1)))
    for index, row in enumerate(rows):
        made[index, : len(row)] = row
    return made
