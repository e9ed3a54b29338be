"""Friction of the load that differs by direction: a worn screw, a seal lip."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ..drive.compiled import kernel
from ..drive.parameters import DriveParameters
from ..drive.rigid.model import plus
from . import constant_load, load_coulomb_friction, load_viscous_friction
from .along import Along
from .effect import Effect, Evidence, Quantity, Start, bristle, put_bristle
from .rigid_form import RigidForm, added, level, per_speed
from .starts import direction, regress
from .term import Fitted, Term


def starts(evidence: Evidence) -> list[Start]:
    """The unexplained torque's level and slope in each direction."""
    sign = direction(evidence)
    speed = evidence.rotor_speed_rad_s
    values = {}
    for name, way in (("positive", 1.0), ("negative", -1.0)):
        along = np.where(sign == way, evidence.torque_nm, np.nan)
        level, slope = regress(along, np.full_like(speed, -way), -speed)
        values[f"coulomb_{name}_nm"] = max(float(level), 1e-4)
        values[f"viscous_{name}_nm_s_per_rad"] = float(slope)
    return [values]


def modify(record: np.ndarray, values: Mapping[str, float], drive: DriveParameters) -> None:
    """Let the contact give as the bristle says."""
    put_bristle(record, "load", values)


def gives_way(values: Start, drive: DriveParameters) -> list[dict[str, Start]]:
    """Friction of one level and a constant load, which differ from it where the motion rests; or
    beside drag of the rotor, which differs where the flanks part."""
    forwards, backwards = values["coulomb_positive_nm"], values["coulomb_negative_nm"]
    known = {one.name for one in bristle("load")}
    friction = {key: value for key, value in values.items() if key in known}
    friction["coulomb_nm"] = 0.5 * (forwards + backwards)
    load = 0.5 * (forwards - backwards) / drive.transmission.rod_per_rotor
    rises = [values[f"viscous_{one}_nm_s_per_rad"] for one in ("positive", "negative")]
    found: list[dict[str, Start]] = [
        {"load_coulomb_friction": friction, "constant_load": {"force_n": load}}
    ]
    if min(rises) > 0.0:
        drag = {"viscous_nm_s_per_rad": 0.5 * sum(rises)}
        found.append({"load_coulomb_friction": friction, "rotor_viscous_friction": drag})
    return found


EFFECT = Effect(
    name="direction_dependent_friction",
    block="load",
    title="friction that depends on direction",
    summary="Friction on the load is higher in one direction than in the other, in level or in its "
    "rise with speed: one flank of the screw is worn, a seal lip points one way.",
    excitation="motion in both directions at several speeds",
    parameters=(
        Quantity(
            name="coulomb_positive_nm", unit="N m", low=0.0, high=1e3, meaning="level, forwards"
        ),
        Quantity(
            name="coulomb_negative_nm", unit="N m", low=0.0, high=1e3, meaning="level, backwards"
        ),
        Quantity(
            name="viscous_positive_nm_s_per_rad",
            unit="N m s/rad",
            low=-10.0,
            high=100.0,
            meaning="rise with speed beyond nominal, forwards",
            default=0.0,
        ),
        Quantity(
            name="viscous_negative_nm_s_per_rad",
            unit="N m s/rad",
            low=-10.0,
            high=100.0,
            meaning="rise with speed beyond nominal, backwards",
            default=0.0,
        ),
        *bristle("load"),
    ),
    starts=starts,
    modify=modify,
    refines=("load_coulomb_friction", "load_viscous_friction"),
    gives_way=gives_way,
    sized=(
        "coulomb_positive_nm",
        "coulomb_negative_nm",
        "viscous_positive_nm_s_per_rad",
        "viscous_negative_nm_s_per_rad",
    ),
)


_STROKES = 2  # each way: with one, nothing says that the next is like it
_AT_BOUND = 1e-6  # of the largest coefficient: so near, it is the bound
_STEMS = (
    level("coulomb_positive", "level, forwards"),
    level("coulomb_negative", "level, backwards"),
    per_speed("viscous_positive", "rise with speed, forwards"),
    per_speed("viscous_negative", "rise with speed, backwards"),
)


def term(along: Along) -> Term:
    """Level and rise with speed of a rigid drive, each by direction."""
    units, speed = along.units, along.motion.velocity
    stems = [one.name for one in _STEMS]
    names = [(units.level(one), units.effort) for one in stems[:2]]
    names += [(units.per_speed(one), units.speed_unit) for one in stems[2:]]
    return Term(
        effect="direction_dependent_friction",
        key="by_direction",
        columns=np.stack(
            [along.forwards, along.backwards, np.maximum(speed, 0.0), np.minimum(speed, 0.0)]
        ),
        parameters=lambda c: tuple(
            (name, unit, float(value)) for (name, unit), value in zip(names, c, strict=True)
        ),
        values=lambda c: dict(zip(stems, map(float, c), strict=True)),
        low=(*along.least_coulomb(), *along.least_viscous()),
        refines=(f"{along.side}_coulomb_friction", f"{along.side}_viscous_friction"),
        holds=("constant_load",),  # its levels are friction plus and less a load
        mean=True,
        # Back EMF bends its values; a difference it does not make.
        bent_by=("back_emf_error",) if along.machine.actuation == "voltage" else (),
    )


def _gives_way(along: Along, held: bool) -> list[list[Term]]:
    """Friction of one level and a constant load; alone, neither would have been enough."""
    pair = [load_coulomb_friction.term(along)]
    if not held:
        pair.append(constant_load.term(along))
    return [pair, [*pair, load_viscous_friction.term(along)]]


def _void(fitted: Fitted) -> str:
    """It has to differ by direction, in more than one stroke each way, and to be friction in both.

    Of one stroke each way the direction is but the earlier and the later part of the time.
    """
    if min(fitted.along.strokes) < _STROKES:
        return "one direction was gone in once: what changed with time or place would do as well"
    values = fitted.values
    if np.any(values - np.array(fitted.term.low) <= _AT_BOUND * np.abs(values).max()):
        return "one direction is at its bound"
    for between in (np.array([1.0, -1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0, -1.0])):
        if abs(float(between @ values)) > fitted.half_width(between):
            return ""
    return "it is the same in both directions"


RIGID = RigidForm(
    stems=_STEMS,
    term=term,
    tried=lambda along, left: [()] if along.both_ways else [],
    modify=lambda model, values: replace(
        model,
        viscous=plus(model.viscous, values["viscous_positive"], values["viscous_negative"]),
        coulomb=plus(model.coulomb, values["coulomb_positive"], values["coulomb_negative"]),
    ),
    gives_way=_gives_way,
    void=_void,
    merged=added,
)


@kernel
def load_friction(p, speed, torque, angle, time):
    """Level by direction."""
    if speed > 0.0:
        return p.direction_dependent_friction_coulomb_positive_nm
    return p.direction_dependent_friction_coulomb_negative_nm


@kernel
def load_torque(p, time, angle, speed):
    """The rise with speed, by direction."""
    if speed > 0.0:
        return -p.direction_dependent_friction_viscous_positive_nm_s_per_rad * speed
    return -p.direction_dependent_friction_viscous_negative_nm_s_per_rad * speed
