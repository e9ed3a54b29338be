"""Friction of the load in proportion to the torque it transmits: the screw under load."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..arrays import FloatArray
from ..drive.compiled import kernel
from ..drive.parameters import DriveParameters
from ..drive.rigid.model import Model
from .along import Along
from .carried_load import Carried, carried_by
from .effect import Effect, Evidence, Quantity, Start, bristle, put_bristle
from .rigid_form import HUGE, RigidForm, Stem, Values, added
from .starts import direction, regress
from .term import Term
from .waves import wave


def starts(evidence: Evidence) -> list[Start]:
    """Regression of the unexplained torque on the motor's, against the motion."""
    torque = np.abs(evidence.drive.motor.torque_constant * evidence.current_a)
    share = -float(regress(evidence.torque_nm, torque * direction(evidence))[0])
    return [{"coefficient": min(max(share, 1e-3) * factor, 0.9)} for factor in (1.0, 2.0)]


def modify(record: np.ndarray, values: Mapping[str, float], drive: DriveParameters) -> None:
    """Let the contact give as the bristle says."""
    put_bristle(record, "load", values)


EFFECT = Effect(
    name="load_dependent_friction",
    block="load",
    title="load-dependent friction",
    summary="Friction that grows with the torque through the screw: an efficiency below one.",
    excitation="high and low torque at similar speeds",
    parameters=(
        Quantity(
            name="coefficient",
            unit="1",
            low=0.0,
            high=1.0,
            meaning="friction level over the size of the transmitted torque",
        ),
        *bristle("load"),
    ),
    starts=starts,
    modify=modify,
    rarity=2,
)


def term(along: Along, carried: FloatArray) -> Term:
    """Friction in proportion to the load carried, float64[n], by what is explained so far."""
    return Term(
        effect="load_dependent_friction",
        key="load friction",
        columns=(along.sign * np.abs(along.motion.quiet(carried)))[None],
        parameters=lambda c: (("coefficient", "1", float(c[0])),),
        values=lambda c: {"coefficient": float(c[0])},
        low=(0.0,),
        follows=True,
        again=lambda left, values: term(along, left.carried),
        of_effort=False,
    )


def _carried(values: Values, model: Model) -> Carried:
    """What the level is a share of: the load of the model, or an inertia that a file gives."""
    inertia = values.get("inertia")
    return carried_by(model) if inertia is None else Carried(inertia, 0.0, 0.0)


RIGID = RigidForm(
    stems=(
        Stem("coefficient", "share", 0.0, 10.0, "level over the load carried", either=True),
        Stem("inertia", "inertia", 0.0, HUGE, "level over the acceleration", either=True),
    ),
    term=term,
    tried=lambda along, left: [(left.carried,)] if along.both_ways and left.carried.any() else [],
    shape=lambda along, values, effort: (_carried(values, along.model).along(along),),
    coefficients=lambda values: (values.get("coefficient", 1.0),),
    packed=lambda values, model: (values.get("coefficient", 1.0), *_carried(values, model)),
    merged=lambda old, new, along: None if "inertia" in old else added(old, new, along),
)


@kernel
def load_friction(p, speed, torque, angle, time):
    """Level: a share of what is transmitted."""
    return p.load_dependent_friction_coefficient * abs(torque)


@kernel
def rigid_level(v, time, position, speed, acceleration):
    """Level: a share of what is carried; v: coefficient, and `Carried`."""
    weight = wave(v[4], 1.0, v[5], position)
    return v[0] * abs(v[1] * acceleration + v[2] + v[3] * position + weight)
