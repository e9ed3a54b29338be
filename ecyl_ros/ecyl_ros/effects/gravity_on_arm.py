"""The weight of an arm that the output turns: a torque over its angle, once per turn."""

from __future__ import annotations

from ..drive.compiled import kernel
from .along import Along
from .effect import Effect
from .rigid_form import HUGE, RigidForm, Stem
from .term import Term
from .waves import parts, phase_stem, sine, wave

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
    """A sine of the angle, once per turn; of an output that goes round cogging may be one, too."""
    return sine(
        along.motion.position,
        "amplitude",
        (along.units.level("amplitude"), along.units.effort),
        effect="gravity_on_arm",
        key="gravity",
        refines=("constant_load", "spring_load"),
        alternatives=("cogging_torque", "encoder_eccentricity") if along.turns else (),
        mean=True,
    )


RIGID = RigidForm(
    stems=(Stem("amplitude", "level", 0.0, HUGE, "weight of an arm"), phase_stem("angle 0")),
    term=term,
    tried=lambda along, left: [] if along.machine.linear else [()],
    coefficients=lambda values: parts(values["amplitude"], values["phase"]),
    twins=("spring_load",),
)


@kernel
def rigid_load(v, time, position):
    """A sine of the angle; v: amplitude, phase."""
    return wave(v[0], 1.0, v[1], position)
