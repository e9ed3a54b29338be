"""The load that a rigid machine carries: what inertia, constant load, spring and weight ask for."""

from __future__ import annotations

from typing import NamedTuple

from ..arrays import FloatArray
from ..drive.rigid.model import Model
from .along import Along
from .gravity_on_arm import weight_of
from .waves import begin, parts, quadratures, size


class Carried(NamedTuple):
    """Of a model, in its unit of effort and SI of the output; amplitude and phase: of a weight."""

    inertia: float
    constant: float
    stiffness: float
    amplitude: float = 0.0
    phase: float = 0.0

    def along(self, along: Along) -> FloatArray:
        """Along a motion, float64[n]."""
        motion = along.motion
        made: FloatArray = self.inertia * motion.acceleration + self.constant
        made += self.stiffness * motion.position
        if self.amplitude:
            made += parts(self.amplitude, self.phase) @ quadratures(motion.position)
        return made


def carried_by(model: Model) -> Carried:
    """What the constants of a model carry, its effects included."""
    weight = weight_of(model.shapes)
    return Carried(
        model.inertia or 0.0, model.constant, model.stiffness, size(weight), begin(weight)
    )


def carried_by_gain(along: Along) -> FloatArray:
    """What of `Along.of_gain` is load that the machine carries, float64[n]."""
    model = along.model
    if along.units.own:
        return carried_by(model).along(along) / model.ratio
    keys = model.keys
    return Carried(keys.inertia, keys.constant, keys.stiffness).along(along)
