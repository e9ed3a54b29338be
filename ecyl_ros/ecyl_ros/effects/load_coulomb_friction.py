"""Coulomb friction behind the backlash: screw, nut, guide, rod seal."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ..drive.compiled import kernel
from ..drive.parameters import DriveParameters
from ..drive.rigid.model import plus
from . import constant_load
from .along import Along
from .effect import Effect, Evidence, Quantity, Start, bristle, put_bristle
from .rigid_form import RigidForm, added, level
from .starts import direction, regress
from .term import Term


def starts(evidence: Evidence) -> list[Start]:
    """The step that the unexplained torque makes with the direction of motion."""
    size = -float(
        regress(evidence.torque_nm, direction(evidence), np.ones_like(evidence.time_s))[0]
    )
    return [{"coulomb_nm": max(size, 1e-4) * factor} for factor in (1.0, 0.4, 2.0)]


def modify(record: np.ndarray, values: Mapping[str, float], drive: DriveParameters) -> None:
    """Let the contact give as the bristle says."""
    put_bristle(record, "load", values)


EFFECT = Effect(
    name="load_coulomb_friction",
    block="load",
    title="Coulomb friction on the load",
    summary="A torque of constant size against the load's motion; the load stays where it is while "
    "the rotor crosses the backlash.",
    excitation="reversals, some of them slow",
    separated_by="the backlash separates it from friction on the rotor",
    parameters=(
        Quantity(
            name="coulomb_nm", unit="N m", low=0.0, high=1e3, meaning="friction torque at the rotor"
        ),
        *bristle("load"),
    ),
    starts=starts,
    modify=modify,
)


def term(along: Along) -> Term:
    """Friction of one level in a rigid drive, on its rotor where it turns."""
    name, unit = along.units.level("coulomb"), along.units.effort
    like = (constant_load.EFFECT.name, *constant_load.offsets(along))
    return Term(
        effect=f"{along.side}_coulomb_friction",
        key="coulomb",
        columns=along.sign[None],
        parameters=lambda c: ((name, unit, float(c[0])),),
        values=lambda c: {"coulomb": float(c[0])},
        low=(max(along.least_coulomb()),),
        alternatives=() if along.both_ways else like,
        mean=not along.both_ways,
    )


RIGID = RigidForm(
    outputs=("linear",),
    stems=(level("coulomb", "friction level"),),
    term=term,
    modify=lambda model, values: replace(model, coulomb=plus(model.coulomb, values["coulomb"])),
    constant=("load.coulomb_friction",) * 2,
    on_top=True,
    merged=added,
)


@kernel
def load_friction(p, speed, torque, angle, time):
    """Level: constant."""
    return p.load_coulomb_friction_coulomb_nm
