"""Friction of the load in proportion to the torque it transmits: the screw under load."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..drive.compiled import kernel
from ..drive.parameters import DriveParameters
from ..drive.rigid.model import Model
from .along import Along
from .effect import Effect, Evidence, Quantity, Start, bristle, put_bristle
from .gravity_on_arm import weight_of
from .rigid_form import HUGE, RigidForm, Stem, Values, added
from .starts import direction, regress
from .term import Term
from .waves import begin, parts, quadratures, size, wave


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


def term(along: Along, shared: bool) -> Term:
    """Friction in proportion to the load carried: to what inertia, constant load, spring and weight
    of the file ask.

    shared: over that load; by the acceleration alone where no inertia is known.
    """
    motion = along.motion
    acceleration = motion.quiet(motion.acceleration)
    inertia, constant, stiffness, amplitude, phase = _carried(along.model)
    carried = inertia * acceleration + constant + stiffness * motion.position
    carried = carried + parts(amplitude, phase) @ quadratures(motion.position)
    name, unit = ("coefficient", "1") if shared else along.units.inertia
    stem = "share" if shared else "inertia"
    return Term(
        effect="load_dependent_friction",
        key="load friction",
        columns=(along.sign * np.abs(carried if shared else acceleration))[None],
        parameters=lambda c: ((name, unit, float(c[0])),),
        values=lambda c: {stem: float(c[0])},
        low=(0.0,),
    )


def _packed(values: Values, model: Model) -> tuple[float, ...]:
    if "inertia" in values:
        return values["inertia"], 1.0, 0.0, 0.0, 0.0, 0.0
    return values["share"], *_carried(model)


def _carried(model: Model) -> tuple[float, float, float, float, float]:
    """Inertia, constant load, stiffness, and amplitude and phase of a weight, by the file's own
    gain."""
    counted, keys = model.counted, model.keys
    inertia = counted * keys.inertia or (model.inertia or 0.0)
    weight = weight_of(model.shapes) / (model.ratio / (counted or 1.0) or 1.0)
    return (
        inertia,
        counted * keys.constant,
        counted * keys.stiffness,
        size(weight),
        begin(weight),
    )


RIGID = RigidForm(
    stems=(
        Stem("share", "coefficient", 0.0, 10.0, "level over the nominal load carried", either=True),
        Stem("inertia", "inertia", 0.0, HUGE, "level over the acceleration", either=True),
    ),
    term=term,
    tried=lambda along, left: [(along.known_inertia,)] if along.both_ways else [],
    shape=lambda along, values, effort: ("share" in values,),
    coefficients=lambda values: tuple(values.values()),
    packed=_packed,
    merged=lambda old, new, along: added(old, new, along) if new.keys() == old.keys() else None,
)


@kernel
def load_friction(p, speed, torque, angle, time):
    """Level: a share of what is transmitted."""
    return p.load_dependent_friction_coefficient * abs(torque)


@kernel
def rigid_level(v, time, position, speed, acceleration):
    """Level: a share of what is carried; v: share, inertia, constant load, stiffness, and amplitude
    and phase of a weight."""
    weight = wave(v[4], 1.0, v[5], position)
    return v[0] * abs(v[1] * acceleration + v[2] + v[3] * position + weight)
