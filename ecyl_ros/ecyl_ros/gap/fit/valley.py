"""Looks along one parameter at a time: valleys that no derivative shows the way into."""

from __future__ import annotations

from functools import partial

import numpy as np
from scipy.optimize import minimize_scalar

from ...effects.catalogue import CATALOGUE
from ...effects.effect import Quantity
from ..side_by_side import side_by_side
from .coordinate import PHASE, Coordinate, later
from .fit import Fit, Fitter

NEAR_FLOOR = 1.3  # times a perfect model's cost: no closer look needed
_BRACKET = 0.8  # half width of a search along one parameter, in the fit's coordinates
_TEETH = 49  # points of a comb: two and more in each of its valleys, an eighth of a size apart
_NARROW = 0.03  # the same around what it found: the valley of a limit is a thousandth wide
_SHAPES = (0.25, 0.5, 2.0, 4.0)  # times a shape parameter at the start of its fit
_ENDS = (0.05, 0.95)  # of what runs from one form of an effect to another
_MATTERS = 0.1  # share of the cost that a shape must move to be looked at closely


def near_floor(fit: Fit, fitter: Fitter) -> bool:
    """Whether a fit leaves so little that no closer look is needed."""
    return fit.fitted <= NEAR_FLOOR * fitter.perfect**2


def along(fitter: Fitter, start: Fit, one: Coordinate, *, closely: bool = True) -> Fit:
    """The best along one coordinate: golden sections and parabolas, which no spike can mislead.

    closely: look once more next to what was found, where that leaves more than the floor.
    """
    best = start

    def made(point: float) -> Fit:
        values = {name: dict(given) for name, given in start.values.items()}
        values[one.effect][one.quantity.name] = one.outward(float(point))
        return fitter.evaluate(values, start.pulls)

    def at(point: float) -> float:
        nonlocal best
        found = made(point)
        if found.fitted < best.fitted:
            best = found
        return found.fitted

    middle = one.inward(start.values[one.effect][one.quantity.name])
    width = _BRACKET
    if fitter.amplified:  # how flanks rattle makes a comb of valleys: into the deepest of all first
        low, high = max(one.low, middle - width), min(one.high, middle + width)
        comb = side_by_side(made, np.linspace(low, high, _TEETH).tolist())
        best = min([best, *comb], key=lambda fit: fit.fitted)
        middle = one.inward(best.values[one.effect][one.quantity.name])
        width *= 2.0 / (_TEETH - 1)
    for _ in range(2):
        low, high = max(one.low, middle - width), min(one.high, middle + width)
        found = minimize_scalar(
            at, bounds=(low, high), method="bounded", options={"xatol": 1e-3, "maxiter": 13}
        )
        edge = 0.08 * (high - low)
        if low + edge < found.x < high - edge:
            break
        middle = float(found.x)  # the valley lies beyond: once more around its rim
    if closely and not near_floor(best, fitter):
        middle = one.inward(best.values[one.effect][one.quantity.name])
        low, high = max(one.low, middle - _NARROW), min(one.high, middle + _NARROW)
        minimize_scalar(
            at, bounds=(low, high), method="bounded", options={"xatol": 1e-5, "maxiter": 15}
        )
    return best


def turned(fitter: Fitter, start: Fit) -> Fit:
    """Other frequencies with the phase in the middle of the recording held.

    Frequency and phase make a narrow valley that runs across the axes of a fit.
    """
    best = start
    end = max(float(one.time_s[-1]) for one in fitter.replay.parts)
    for name, given in start.values.items():
        for frequency in [one.name for one in CATALOGUE[name].parameters if one.unit == "Hz"]:
            others = []
            for offset in np.linspace(-0.3, 0.3, 13) / end:
                other = later({**given, **best.values[name]}, -np.pi * offset * end)
                other[frequency] += offset
                others.append({**best.values, name: other})
            tried = side_by_side(partial(fitter.evaluate, pulls=best.pulls), others)
            best = min([best, *tried], key=lambda one: one.fitted)
    return best


def shaped(fitter: Fitter, start: Fit) -> Fit:
    """Better values of the parameters that only shape an effect (no phase).

    The best of several; where that matters and something is left, the bottom of its valley.
    """
    best = start
    for name in start.values:
        for one in _shapes(name):
            middle = best.values[name][one.name]
            shapes = [min(max(middle * factor, one.low), one.high) for factor in _SHAPES]
            others = [
                {**best.values, name: {**best.values[name], one.name: shape}} for shape in shapes
            ]
            tried = side_by_side(partial(fitter.evaluate, pulls=best.pulls), others)
            costs = [best.fitted, *(other.fitted for other in tried)]
            best = min([best, *tried], key=lambda other: other.fitted)
            matters = max(costs) - min(costs) > _MATTERS * min(costs)
            if matters and not near_floor(best, fitter):
                value = best.values[name][one.name]
                best = along(fitter, best, Coordinate.around(name, one, value))
        best = _blended(fitter, best, name)
    return best


def _shapes(name: str) -> list[Quantity]:
    return [one for one in CATALOGUE[name].parameters if one.nuisance and one.name != PHASE]


def _blended(fitter: Fitter, start: Fit, name: str) -> Fit:
    """The better end of what runs from one form of an effect (0) to another (1).

    Size and other shapes that suit one form lead away from the other, so that no small step in
    between is better: they are fitted again at either end.
    """
    best = start
    for blend in (one for one in _shapes(name) if one.unit == "1" and one.high == 1.0):
        size = CATALOGUE[name].parameters[0]
        others = [one for one in _shapes(name) if one is not blend]
        for end in _ENDS:
            if near_floor(best, fitter):
                return best
            values = {**start.values, name: {**start.values[name], blend.name: end}}
            tried = fitter.evaluate(values, start.pulls)
            for one in (*others, size):
                value = tried.values[name][one.name]
                tried = along(fitter, tried, Coordinate.around(name, one, value))
            best = min(best, tried, key=lambda one: one.fitted)
    return best
