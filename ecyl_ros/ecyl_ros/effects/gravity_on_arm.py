"""The weight of an arm that the output turns: a torque over its angle, once per turn."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from ..arrays import FloatArray
from ..drive.compiled import kernel
from ..drive.rigid.model import Acting
from .along import Along
from .effect import Effect
from .rigid_form import HUGE, RigidForm, Stem, Values
from .term import Fitted, Parameters, Term, holds_nominal, plain
from .waves import begin, parts, phase_stem, sine, size, wave

EFFECT = Effect(
    name="gravity_on_arm",
    block="load",
    title="gravity on arm",
    summary="A torque that repeats with the angle of the output, at rest as in motion: a weight "
    "off the axis.",
    excitation="slow motion both ways through as much of a turn as there is",
    parameters=(),
    cylinder=False,  # a straight output has no arm
)


def term(along: Along) -> Term:
    """A sine of the angle, once per turn; of an output that goes round cogging may be one, too.

    There is one weight: what is told is that of the file and what comes on top of it together.
    """
    units, stated = along.units, _stated(along)

    def parameters(c: FloatArray) -> Parameters:
        both = c + stated
        amplitude = (units.level("amplitude"), units.effort, size(both))
        return amplitude, ("phase_rad", "rad", begin(both))

    made = sine(
        along.motion.position,
        "amplitude",
        (units.level("amplitude"), units.effort),
        effect="gravity_on_arm",
        key="gravity",
        refines=("constant_load", *(("spring_load",) if along.on_small_arc else ())),
        alternatives=("cogging_torque", "encoder_eccentricity") if along.turns else (),
        mean=True,
    )
    return replace(made, parameters=parameters, carried=made.columns)


def _stated(along: Along) -> FloatArray:
    """Coefficients of the weight in the file."""
    return weight_of(along.machine.effects)


def weight_of(effects: Iterable[Acting]) -> FloatArray:
    """Coefficients of `waves.quadratures` over the angle, float64[2], of all weights at work."""
    found = [one.values for one in effects if one.name == EFFECT.name]
    return np.sum([parts(one["amplitude"], one["phase"]) for one in found] or [(0.0, 0.0)], axis=0)


def _merged(old: Values, new: Values, along: Along) -> Values:
    both = np.sum([parts(one["amplitude"], one["phase"]) for one in (old, new) if one], axis=0)
    return {"amplitude": size(both), "phase": begin(both)}


def _void(fitted: Fitted) -> str:
    stated = _stated(fitted.along)
    if not stated.any():
        return plain(fitted)
    amplitude, phase = fitted.spans
    return holds_nominal(amplitude, size(stated)) and holds_nominal(phase, begin(stated))


RIGID = RigidForm(
    stems=(
        Stem("amplitude", "level", 0.0, HUGE, "weight of an arm, against positive motion"),
        phase_stem("angle 0 (0: the arm hangs there, 1.57: it is level and rises)"),
    ),
    term=term,
    tried=lambda along, left: [] if along.machine.linear else [()],
    coefficients=lambda values: parts(values["amplitude"], values["phase"]),
    twins=("spring_load", "cogging_torque"),
    void=_void,
    merged=_merged,
)


@kernel
def rigid_load(v, time, position):
    """A sine of the angle; v: amplitude, phase."""
    return wave(v[0], 1.0, v[1], position)
