"""The limits of a full cylinder's recording, by replays about the model that was found."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence

import numpy as np

from ...effects.catalogue import CATALOGUE
from ..fit.fit import Fit, Fitter
from ..side_by_side import side_by_side
from .chance import CHANCE, Machines, Visible
from .columns import Base
from .limit import Alike, Limit
from .pairs import alike
from .probes import Probe, Scale, probes
from .seen import Seen

# Real faults differ from the model's form, and the linear look from the fit: with this the study
# (benchmarks/detection_limits.py) sees 95 of 100; without it 92, with 1.1 it sees 98.
FORM = 1.05
_NEAR = 1.6  # factor within which the size looked at is the smallest that is seen
_LOOKS = 5  # at the most
_LEAST_CAP, _CAP_LOOKS = 1e-3, 9  # share of what is asked for; halvings of its logarithm
_FARTHER = 30.0  # factor of the size from one look to the next at the most


def seen_by(
    fitter: Fitter,
    fit: Fit,
    names: Collection[str],
    known: Base | None = None,
) -> tuple[Base, list[Seen]]:
    """The smallest visible size of each effect in every shape, about a fit.

    known: the base of this fit, where it is at hand.
    """
    base = known or Base.of(fitter, fit)
    machines = Machines.drawn(base)
    scale = Scale.of(fitter.replay, fit.values, fitter.sheet.constants(fit.pulls))
    drive = fitter.replay.nominal
    asked = [one for name in names for one in probes(name, drive, scale)]
    return base, side_by_side(lambda one: _smallest(machines, one), asked)


def limits_of(
    fitter: Fitter, fit: Fit, without: Collection[str] = ()
) -> tuple[tuple[Limit, ...], tuple[Alike, ...]]:
    """What the recording would have shown beside `fit`, and what it cannot tell apart.

    without: effects that did not compete.
    """
    taken = {*fit.names, *without}
    names = [name for name in CATALOGUE if name not in taken]
    base, found = seen_by(fitter, fit, names)
    return tuple(one.limit for one in least_visible(found)), alike(base, least_visible(found))


def least_visible(found: Sequence[Seen]) -> list[Seen]:
    """Of each effect the shape that takes the largest size to be seen."""
    worst: dict[str, Seen] = {}
    for one in found:
        name = one.probe.effect
        if name not in worst or one.size > worst[name].size:
            worst[name] = one
    return list(worst.values())


def _smallest(machines: Machines, probe: Probe) -> Seen:
    """The size that is seen with 95 %, looked at again where it is far from the last look."""
    own = machines.without(probe.effect)
    if probe.caps:
        return _from_where(own, probe)
    size = min(probe.first, probe.largest)
    for _ in range(_LOOKS):
        response = own.base.response(probe, size)
        if not np.any(np.abs(response) > 1e-3):
            times = math.inf
        else:
            times = Visible(own, response, own.base.own(probe, size)).smallest()
        if 1.0 / _NEAR < times < _NEAR:
            return Seen(probe, min(FORM * times * size, probe.largest), response)
        if times >= 1.0 and size >= probe.largest:
            break
        size = min(size * min(max(times, 1.0 / _FARTHER), _FARTHER), probe.largest)
    else:
        if times < _FARTHER:
            return Seen(probe, size, response)
    return Seen(probe, math.inf, response)


def _from_where(machines: Machines, probe: Probe) -> Seen:
    """The same of what acts from some value on: no response can be scaled to another size."""
    low, high = _LEAST_CAP * probe.neutral, probe.largest
    response = machines.base.response(probe, high)
    if Visible(machines, response).chance(1.0) < CHANCE:
        return Seen(probe, math.inf, response)
    for _ in range(_CAP_LOOKS):
        middle = math.sqrt(low * high)
        shown = machines.base.response(probe, middle)
        if Visible(machines, shown).chance(1.0) >= CHANCE:
            high, response = middle, shown
        else:
            low = middle
    return Seen(probe, high, response)
