"""A spring on the rod: a hose, a seal stack, an elastic counterpart."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from ..drive.compiled import kernel
from ..drive.rigid.model import Model
from .along import Along
from .effect import Effect, Evidence, Quantity, Start
from .rigid_form import HUGE, RigidForm, Stem, Values
from .starts import regress
from .term import Left, Term


def starts(evidence: Evidence) -> list[Start]:
    """The slope of the unexplained torque over the rod's position."""
    ratio = evidence.drive.transmission.rod_per_rotor
    slope, _ = regress(evidence.torque_nm, evidence.rotor_angle_rad, np.ones_like(evidence.time_s))
    stiffness = max(-float(slope), 1e-9) / ratio**2
    return [{"stiffness_n_per_m": stiffness * factor} for factor in (1.0, 0.3, 2.5)]


EFFECT = Effect(
    name="spring_load",
    block="load",
    title="spring load",
    summary="A force towards position zero in proportion to the distance from it.",
    excitation="travel, and rest at different positions",
    parameters=(
        Quantity(name="stiffness_n_per_m", unit="N/m", low=0.0, high=1e10, meaning="at the rod"),
    ),
    starts=starts,
    rarity=2,
)


def term(along: Along) -> Term:
    """An effort in proportion to position; its rest position goes into a constant."""
    units, position = along.units, along.motion.position
    name, unit = units.per_position("stiffness"), f"{units.effort}/{units.end}"
    middle = float(np.median(position[along.motion.usable]))
    return Term(
        effect="spring_load",
        key="spring",
        columns=np.stack([position - middle, along.one]),
        parameters=lambda c: ((name, unit, float(c[0])),),
        values=lambda c: {
            "stiffness": float(c[0]),
            "rest": middle - float(c[1] / c[0]) if c[0] else 0.0,
        },
        low=(-along.model.stiffness, -math.inf),
        refines=("constant_load",),
        mean=True,
    )


def _candidates(along: Along, left: Left) -> list[Term]:
    return [term(along)]


def _like(along: Along, left: Left, other: Term) -> Term:
    """Over a small travel a weight is a slope, which may fall as well as rise."""
    return replace(term(along), key="slope", low=(-math.inf,) * 2)


def _modify(model: Model, values: Values) -> Model:
    return replace(
        model,
        stiffness=model.stiffness + values["stiffness"],
        constant=model.constant - values["stiffness"] * values["rest"],
    )


RIGID = RigidForm(
    stems=(
        Stem("stiffness", "per_position", -HUGE, HUGE, "spring rate"),
        Stem("rest", "position", -HUGE, HUGE, "where it is slack", default=0.0),
    ),
    candidates=_candidates,
    modify=_modify,
    like=_like,
    constant=("load.stiffness",) * 2,
    on_top=True,
)


@kernel
def load_torque(p, time, angle, speed):
    """Towards position zero."""
    return -p.spring_load_stiffness_n_per_m * p.rod_per_rotor * p.rod_per_rotor * angle
