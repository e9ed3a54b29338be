"""What it would save to let one constant leave the sheet for nothing.

Constants that can nearly be exchanged for one another share a fault between them: a torque
constant off by three tolerances pulls every inertia and friction the other way, and none far.
The price of all together falls as soon as the right one is free; how far, and where all would go,
follows from the curvature of the objective (its Laplace approximation), without another fit.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ...arrays import FloatArray
from ...effects.catalogue import CATALOGUE
from ..fit.fit import Fit, Fitter, Values
from ..fit.gram import weighted_products
from ..fit.robust import per_square, robust_weights
from ..inverse import inverse_of
from ..sheet import PULL_PRICE, stated

# The square of a normal variable that is two tolerances, four standard deviations, off. A sheet has
# a dozen constants: one healthy machine in a thousand has one so far off by chance.
STRAINED = 16.0
SOUND = math.sqrt(STRAINED / PULL_PRICE)  # the same in tolerances
UNSEEN = 1e-3  # share below which a constant is where the sheet has it


@dataclass(frozen=True, eq=False)
class Strain:
    """One constant let go.

    Attributes:
        row: of the sheet. saved: by how much the objective falls; the square of a normal variable
            where the sheet holds. counted: the same where tolerances are counted as data sheets do,
            see `sheet.stated`. pull: where the constant goes.
        values, pulls: where the effects' parameters and the other constants go with it.
    """

    row: int
    saved: float
    counted: float
    pull: float
    values: Values
    pulls: FloatArray


def strains(fit: Fit, fitter: Fitter) -> list[Strain]:
    """Every constant that was fitted, the most strained first; none without derivatives."""
    if fit.jacobian is None or not fit.pulled:
        return []
    first = len(fit.coordinates)
    residual = fit.gap[:, fitter.rows].ravel()
    weight = robust_weights(residual)
    pieces = per_square(fitter.sheet.evidence, weight, residual)
    price = np.diag([0.0] * first + [PULL_PRICE] * len(fit.pulled))
    curvature = pieces * weighted_products(fit.jacobian, weight, residual)[0] + price
    inverse, relative = inverse_of(curvature), fitter.sheet.relative
    found = []
    for index, row in enumerate(fit.pulled, first):
        # What the recording says of it, as a share of what it and the sheet say together.
        seen = 1.0 - PULL_PRICE * float(inverse[index, index])
        if seen <= UNSEEN:
            continue
        pull = float(fit.pulls[row])
        moved = inverse[:, index] * PULL_PRICE * pull / seen
        values = {name: dict(given) for name, given in fit.values.items()}
        for one, off in zip(fit.coordinates, moved, strict=False):
            old = values[one.effect][one.quantity.name]
            new = one.outward(min(max(one.of(old) + float(off), one.low), one.high))
            values[one.effect][one.quantity.name] = new
        pulls = fit.pulls.copy()
        pulls[list(fit.pulled)] += moved[first:]
        free = pull / seen
        counted = float(price_beyond(np.array(free), np.array(seen), relative[row]))
        found.append(Strain(row, PULL_PRICE * pull * free, counted, free, values, pulls))
    return sorted(found, key=lambda one: -one.saved)


def price_beyond(free: FloatArray, seen: FloatArray, relative: FloatArray) -> FloatArray:
    """What it saves to let constants go to the pulls `free`, counted as data sheets do.

    seen: what the recording says of each, as a share of what it and the sheet say. relative: their
    tolerances, see `sheet.stated`. float64[..., k].
    """
    made: FloatArray = PULL_PRICE * seen * stated(free, relative) ** 2
    return made


def most_strained(fit: Fit, fitter: Fitter) -> Strain | None:
    """The constant that lies furthest beyond its sheet, of those that effects stand for.

    None where all may be those of a healthy machine.
    """
    return furthest(fit, fitter, lambda row: effect_of(row, fitter) is not None)


def furthest(fit: Fit, fitter: Fitter, counts: Callable[[int], bool]) -> Strain | None:
    """The constant that lies furthest beyond its sheet, of those whose row counts.

    None where all may be those of a healthy machine.
    """
    beyond = (one for one in strains(fit, fitter) if counts(one.row) and one.counted > STRAINED)
    return next(beyond, None)


def effect_of(row: int, fitter: Fitter) -> str | None:
    """The effect that gives a constant another value; None where the catalogue has none."""
    key = fitter.sheet.keys[row]
    return next((name for name, one in CATALOGUE.items() if one.constant == key), None)
