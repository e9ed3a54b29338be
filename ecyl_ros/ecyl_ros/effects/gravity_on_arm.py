"""The weight of an arm that the output turns: a torque over its angle, once per turn."""

from __future__ import annotations

import math

from ..drive.compiled import kernel
from .along import Along
from .effect import Effect, FloatArray
from .rigid_form import HUGE, RigidForm, Stem, Values
from .term import Left, Term
from .waves import parts, phase_stem, polar, quadratures, size, wave

EFFECT = Effect(
    name="gravity_on_arm",
    block="load",
    title="gravity on arm",
    summary="A torque that goes round with the angle of the output, at rest as in motion: a weight "
    "off the axis.",
    excitation="",
    parameters=(),
    cylinder=False,  # a straight output has no arm
)


def term(along: Along) -> Term:
    """A sine of the angle, once per turn."""
    units = along.units
    return Term(
        effect="gravity_on_arm",
        key="gravity",
        columns=quadratures(along.motion.position),
        parameters=lambda c: ((units.level("amplitude"), units.effort, size(c)),),
        values=lambda c: polar("amplitude", c),
        low=(-math.inf, -math.inf),
        refines=("constant_load", "spring_load"),
        mean=True,
    )


def _candidates(along: Along, left: Left) -> list[Term]:
    return [] if along.machine.linear or along.turns else [term(along)]


def _asked(along: Along, values: Values, effort: FloatArray) -> FloatArray:
    made: FloatArray = parts(values["amplitude"], values["phase"]) @ term(along).columns
    return made


RIGID = RigidForm(
    stems=(Stem("amplitude", "level", 0.0, HUGE, "weight of an arm"), phase_stem("angle 0")),
    candidates=_candidates,
    asked=_asked,
    twins=("spring_load",),
)


@kernel
def rigid_load(v, time, position):
    """A sine of the angle; v: amplitude, phase."""
    return wave(v[0], 1.0, v[1], position)
