"""Several causes that are off by one factor, as one fault of another kind would show.

A current that is read a fifth too large looks, to who believes the reading, like a torque constant,
a supply and a back EMF that are each off by a fifth: constants off by one factor are one wrong
unit. Independent faults agree so closely in a few cases of a hundred.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from ..drive.parameters import DriveParameters
from ..effects.catalogue import CATALOGUE
from .compete import Competition
from .constancy import without_effects
from .fit import Fitter

# What the wrong unit of current, and of torque, would seem to change.
UNITS = (
    {
        "torque_constant_error",
        "back_emf_error",
        "resistance_error",
        "inverter_gain",
        "current_sensor_gain",
    },
    {"torque_constant_error", "current_sensor_gain", "rotor_inertia_error", "load_inertia_error"},
)
MAGNETS = {"torque_constant_error", "back_emf_error"}  # weak magnets lower both, and truly so
_AGREE, _LEAST, _MOST = 0.05, 0.004, 0.01  # of the logarithm of a factor, and bounds of that


@dataclass(frozen=True)
class Coincidence:
    """Effects that are off by one factor or its inverse, and that factor, above 1."""

    effects: tuple[str, ...]
    factor: float


def coincidence(
    values: Mapping[str, Mapping[str, float]], drive: DriveParameters
) -> Coincidence | None:
    """The most effects among `values` that agree in their factor; None where no two do."""
    best: dict[str, float] = {}
    for unit in UNITS:
        logs = {
            name: math.log(_factor(name, given, drive))
            for name, given in values.items()
            if name in unit
        }
        for one in map(abs, logs.values()):
            near = min(max(_AGREE * one, _LEAST), _MOST)
            agreeing = {name: log for name, log in logs.items() if abs(abs(log) - one) <= near}
            best = max(best, agreeing, key=len)
    if len(best) < 2 or (set(best) == MAGNETS and math.prod(best.values()) > 0.0):
        return None
    return Coincidence(tuple(best), math.exp(sum(map(abs, best.values())) / len(best)))


def _factor(name: str, values: Mapping[str, float], drive: DriveParameters) -> float:
    """True over nominal, above 0."""
    effect = CATALOGUE[name]
    value = values[effect.parameters[0].name]
    neutral = effect.neutral(drive)
    return max(value / neutral if neutral > 0.0 else 1.0 + value, 1e-12)


def without_coincidence(
    competition: Competition, fitter: Fitter
) -> tuple[Competition, Coincidence | None]:
    """The competition without causes that one fault of another kind stands behind, and those."""
    found = coincidence(competition.winner.values, fitter.replay.drive)
    if found is None:
        return competition, None
    return without_effects(competition, fitter, found.effects), found
