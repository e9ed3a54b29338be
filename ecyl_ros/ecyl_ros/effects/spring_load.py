"""A spring on the rod: a hose, a seal stack, an elastic counterpart."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from ..drive.compiled import kernel
from .along import Along
from .effect import Effect, Evidence, Quantity, Start
from .rigid_form import HUGE, RigidForm, Stem
from .starts import regress
from .term import Term


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


def term(along: Along, slope: bool = False) -> Term:
    """An effort in proportion to position; its rest position goes into a constant.

    slope: of either sign, as a weight is over a small travel.
    """
    units, position = along.units, along.motion.position
    name, unit = units.per_position("stiffness"), f"{units.effort}/{units.end}"
    middle = float(np.median(position[along.motion.usable]))
    columns = np.stack([position - middle, along.one])
    bare = Term(
        effect="spring_load",
        key="spring slack at 0",
        columns=position[None],
        carried=position[None],
        parameters=lambda c: ((name, unit, float(c[0])),),
        values=lambda c: {"stiffness": float(c[0]), "rest": 0.0},
        low=(-along.model.stiffness,),
    )
    return Term(
        effect="spring_load",
        key="slope" if slope else "spring",
        columns=columns,
        carried=columns,
        parameters=lambda c: ((name, unit, float(c[0])),),
        values=lambda c: {
            "stiffness": float(c[0]),
            "rest": middle - float(c[1] / c[0]) if c[0] else 0.0,
        },
        low=(-math.inf if slope else -along.model.stiffness, -math.inf),
        refines=("constant_load",),
        bare=bare,
        alternatives=("gravity_on_arm",) if along.on_small_arc else (),
        mean=True,
    )


RIGID = RigidForm(
    stems=(
        Stem("stiffness", "per_position", -HUGE, HUGE, "spring rate"),
        Stem("rest", "position", -HUGE, HUGE, "where it is slack", default=0.0),
    ),
    term=term,
    modify=lambda model, values: replace(
        model,
        stiffness=model.stiffness + values["stiffness"],
        constant=model.constant - values["stiffness"] * values["rest"],
    ),
    like=lambda along, left, other: (True,),
    constant=("load.stiffness",) * 2,
    on_top=True,
)


@kernel
def load_torque(p, time, angle, speed):
    """Towards position zero."""
    return -p.spring_load_stiffness_n_per_m * p.rod_per_rotor * p.rod_per_rotor * angle
