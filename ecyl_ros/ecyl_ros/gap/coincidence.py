"""Several causes that are off by one factor, as one fault of another kind would show.

A current that is read a fifth too large looks, to who believes the reading, like a torque constant,
a supply and a back EMF that are each off by a fifth; wrong in their proportion, constants are one
wrong unit. That independent faults agree so closely is a matter of a few percent.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from ..drive.parameters import DriveParameters
from ..effects.catalogue import CATALOGUE
from .attribute import Competition
from .constancy import without_effects
from .fit import Fitter

# What a wrong scale of current, voltage or torque would seem to change.
SCALES = (
    "torque_constant_error",
    "back_emf_error",
    "resistance_error",
    "inverter_gain",
    "current_sensor_gain",
    "rotor_inertia_error",
    "load_inertia_error",
)
MAGNETS = {"torque_constant_error", "back_emf_error"}  # weak magnets lower both, and truly so
_AGREE = 0.05  # of the logarithm of a factor
_AGREE_AT_LEAST = 0.004


@dataclass(frozen=True)
class Coincidence:
    """Effects that are off by one factor or its inverse, and that factor, above 1."""

    effects: tuple[str, ...]
    factor: float


def coincidence(
    values: Mapping[str, Mapping[str, float]], drive: DriveParameters
) -> Coincidence | None:
    """The most effects among `values` that agree in their factor; None where no two do."""
    logs = {
        name: math.log(_factor(name, given, drive))
        for name, given in values.items()
        if name in SCALES
    }
    best: list[str] = []
    for one in logs.values():
        near = max(_AGREE * abs(one), _AGREE_AT_LEAST)
        agreeing = [name for name, other in logs.items() if abs(abs(other) - abs(one)) <= near]
        best = max(best, agreeing, key=len)
    if len(best) < 2 or (set(best) == MAGNETS and math.prod(logs[name] for name in best) > 0.0):
        return None
    mean = sum(abs(logs[name]) for name in best) / len(best)
    return Coincidence(tuple(best), math.exp(mean))


def _factor(name: str, values: Mapping[str, float], drive: DriveParameters) -> float:
    """True over nominal."""
    effect = CATALOGUE[name]
    value = values[effect.parameters[0].name]
    neutral = effect.neutral(drive)
    return value / neutral if neutral > 0.0 else 1.0 + value


def without_coincidence(
    competition: Competition, fitter: Fitter
) -> tuple[Competition, Coincidence | None]:
    """The competition without causes that one fault of another kind stands behind, and those."""
    found = coincidence(competition.winner.values, fitter.replay.drive)
    if found is None:
        return competition, None
    return without_effects(competition, fitter, found.effects), found
