"""Viscous friction on the load beyond what the nominal model has."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ..drive.parameters import DriveParameters
from ..drive.rigid.model import plus
from . import constant_load, load_coulomb_friction
from .along import Along
from .effect import Effect, Evidence, Quantity, Start
from .rigid_form import RigidForm, added, per_speed
from .starts import regress
from .term import Fitted, Term, at_bound, holds_nothing, plain


def modify(record: np.ndarray, values: Mapping[str, float], drive: DriveParameters) -> None:
    """Add to the nominal viscous friction."""
    record["load_viscous"] += values["viscous_nm_s_per_rad"]


def starts(evidence: Evidence) -> list[Start]:
    """The slope of the unexplained torque over speed."""
    slope = -float(regress(evidence.torque_nm, evidence.rotor_speed_rad_s)[0])
    scale = max(abs(slope), 0.1 * evidence.drive.load.viscous_friction, 1e-6)
    return [{"viscous_nm_s_per_rad": value} for value in (slope, 3.0 * scale)]


EFFECT = Effect(
    name="load_viscous_friction",
    block="load",
    title="Viscous friction on the load",
    summary="A torque against the load's motion in proportion to its speed, beyond the nominal.",
    excitation="motion at different speeds",
    separated_by="passages through the backlash separate rotor from load",
    parameters=(
        Quantity(
            name="viscous_nm_s_per_rad",
            unit="N m s/rad",
            low=-10.0,
            high=100.0,
            meaning="coefficient at the rotor, beyond nominal",
        ),
    ),
    starts=starts,
    modify=modify,
    constant="load.viscous_friction",
    on_top=True,
)


# Beyond so much variance inflation columns count as one (Marquardt, 1970), unless the recording has
# told them apart all the same.
_INFLATED = 10.0


def term(along: Along) -> Term:
    """Friction of a rigid drive in proportion to speed, on its rotor where it turns."""
    name, unit = along.units.per_speed("viscous"), along.units.speed_unit
    by_voltage = along.machine.actuation == "voltage"
    return Term(
        effect=f"{along.side}_viscous_friction",
        key="viscous",
        columns=along.motion.velocity[None],
        parameters=lambda c: ((name, unit, float(c[0])),),
        values=lambda c: {"viscous": float(c[0])},
        low=(max(along.least_viscous()),),
        alternatives=("back_emf_error",) if by_voltage else (),
    )


def _void(fitted: Fitted) -> str:
    level = [load_coulomb_friction.term(fitted.along), constant_load.term(fitted.along)]
    alike = not at_bound(fitted) and fitted.inflation(level) > _INFLATED
    if alike and holds_nothing(fitted.beside(level)[0]):
        return "the speed varies too little to tell it from friction of one level or a constant"
    return plain(fitted)


RIGID = RigidForm(
    outputs=("linear",),
    stems=(per_speed("viscous", "friction in proportion to speed"),),
    term=term,
    modify=lambda model, values: replace(model, viscous=plus(model.viscous, values["viscous"])),
    constant=("load.viscous_friction",) * 2,
    on_top=True,
    void=_void,
    merged=added,
)
