"""Several causes that are off by one factor, as one fault of another kind would show.

A current that is read a fifth too large looks, to who believes the reading, like a torque constant,
a supply and a back EMF that are each off by a fifth: constants off by one factor are one wrong
unit. Independent faults agree so closely in a few cases of a hundred. The factor is over the sheet,
whose constants are off by themselves: two agree no better than they are known, which says little;
three that agree as far as their tolerances let them are one fault again, for three are rare.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from ...drive.parameters import DriveParameters
from ...effects.catalogue import CATALOGUE
from ..compete.competition import Competition
from ..fit.fit import Fitter
from .constancy import without_effects

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
_SEVERAL = 3  # that may agree as loosely as their tolerances let them
_AGREE, _LEAST, _MOST = 0.05, 0.004, 0.01  # of the logarithm of a factor, and bounds of that


@dataclass(frozen=True)
class Coincidence:
    """Effects that are off by one factor or its inverse, and that factor, above 1."""

    effects: tuple[str, ...]
    factor: float


def coincidence(
    values: Mapping[str, Mapping[str, float]],
    drive: DriveParameters,
    tolerances: Mapping[str, float] | None = None,
) -> Coincidence | None:
    """The most effects among `values` that agree in their factor; None where no two do.

    tolerances: of constants by key of the drive file, as shares; exact unless given.
    """
    known = tolerances or {}
    best: dict[str, float] = {}
    for unit in UNITS:
        logs = {
            name: math.log(_factor(name, given, drive))
            for name, given in values.items()
            if name in unit
        }
        wide = {name: known.get(CATALOGUE[name].constant or "", 0.0) for name in logs}
        for first, one in ((name, abs(log)) for name, log in logs.items()):
            near = min(max(_AGREE * one, _LEAST), _MOST)
            off = {name: abs(abs(log) - one) for name, log in logs.items()}
            agreeing = {name: logs[name] for name in logs if off[name] <= near}
            loosely = {
                name: logs[name]
                for name in logs
                if off[name] <= math.hypot(near, wide[first], wide[name])
            }
            best = max(best, agreeing, loosely if len(loosely) >= _SEVERAL else {}, key=len)
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
    tolerances = dict(zip(fitter.sheet.keys, fitter.sheet.relative.tolist(), strict=True))
    found = coincidence(competition.winner.values, fitter.replay.drive, tolerances)
    if found is None:
        return competition, None
    return without_effects(competition, fitter, found.effects), found
