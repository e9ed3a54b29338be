"""Coulomb friction on the rotor that changes while the run lasts: warming up, drying out."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from ..arrays import FloatArray
from ..drive.compiled import kernel
from ..drive.parameters import DriveParameters
from .along import Along
from .effect import Effect, Evidence, Quantity, Start, bristle, put_bristle
from .rigid_form import HUGE, RigidForm, Stem, level
from .starts import direction, regress
from .term import Parameters, Term, at_bound, holds_nothing


def starts(evidence: Evidence) -> list[Start]:
    """Level and its trend by regression."""
    sign = direction(evidence)
    size, trend = regress(evidence.torque_nm, -sign, -sign * evidence.time_s)
    size = max(float(size), 1e-4)
    return [{"coulomb_nm": size, "rate_per_s": max(float(trend) / size, -0.5)}]


def modify(record: np.ndarray, values: Mapping[str, float], drive: DriveParameters) -> None:
    """Let the contact give as the bristle says."""
    put_bristle(record, "rotor", values)


EFFECT = Effect(
    name="friction_drift",
    block="motor_mechanical",
    title="friction that drifts with time",
    summary="Coulomb friction on the rotor that falls or rises during the run: grease warming up, "
    "a bearing or brake heating.",
    excitation="the same motion early and late in the recording",
    parameters=(
        Quantity(
            name="coulomb_nm", unit="N m", low=0.0, high=1e3, meaning="level at the first sample"
        ),
        Quantity(
            name="rate_per_s",
            unit="1/s",
            low=-1.0,
            high=1.0,
            meaning="exponential rate of change of the level",
        ),
        *bristle("rotor"),
    ),
    starts=starts,
    modify=modify,
    refines=("rotor_coulomb_friction",),
    rarity=2,
)


def term(along: Along) -> Term:
    """A friction level of a rigid drive that changes evenly with time."""
    units = along.units

    def values(c: FloatArray) -> dict[str, float]:
        return {"coulomb": float(c[0]), "rate": float(c[1] / c[0]) if c[0] else 0.0}

    def parameters(c: FloatArray) -> Parameters:
        found = values(c)
        size = (units.level("coulomb"), units.effort, found["coulomb"])
        return size, ("rate_per_s", "1/s", found["rate"])

    return Term(
        effect="friction_drift",
        key="drift",
        columns=np.stack([along.sign, along.sign * along.motion.own_s]),
        parameters=parameters,
        values=values,
        low=(max(along.least_coulomb()), -math.inf),
        refines=(f"{along.side}_coulomb_friction",),
    )


def _told(along: Along) -> bool:
    """Whether a motion tells what drifts with time from what depends on the motion."""
    return along.both_ways and not along.ramped and not along.swept


RIGID = RigidForm(
    stems=(
        level("coulomb", "level at the first sample"),
        Stem("rate", "rate", -HUGE, HUGE, "evenly: the level is coulomb (1 + rate time)"),
    ),
    term=term,
    tried=lambda along, left: [()] if _told(along) else [],
    untold=lambda along, left: [] if _told(along) or along.ramped else [()],
    coefficients=lambda values: (values["coulomb"], values["coulomb"] * values["rate"]),
    void=lambda fitted: at_bound(fitted) or holds_nothing(fitted.spans[1]),
)


@kernel
def rotor_friction(p, speed, torque, time):
    """Level: exponential in time."""
    if p.friction_drift_coulomb_nm == 0.0:
        return 0.0
    return p.friction_drift_coulomb_nm * math.exp(p.friction_drift_rate_per_s * time)


@kernel
def rigid_level(v, time, position, speed, acceleration):
    """Level: even in time, as a regression knows it; v: level, its change over it."""
    return v[0] + v[0] * v[1] * time
