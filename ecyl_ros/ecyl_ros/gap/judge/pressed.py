"""Parameters that only the bound of their fit holds: the data press them against it.

What an effect does fades as its parameter goes to zero, and so does what a recording can say of it:
a fit in logarithms then drifts until it meets the end of its reach, and noise drove it there. The
data press only where the value that they would have without a bound is beyond it by more than the
half width of its 95 % interval.
"""

from __future__ import annotations

import math

import numpy as np

from ..fit.fit import Fit, Fitter
from ..fit.gram import weighted_products
from ..fit.robust import per_square, robust_weights
from ..inverse import inverse_of
from ..sheet import PULL_PRICE
from .intervals import quantile, variances


def pressed(fit: Fit, fitter: Fitter) -> frozenset[str]:
    """Those of a fit's `bounds_hit` that the data press against their bound."""
    if not fit.bounds_hit or fit.jacobian is None:
        return frozenset(fit.bounds_hit)
    residual = fit.gap[:, fitter.rows]
    weight = robust_weights(residual)
    hessian, slope = weighted_products(fit.jacobian, weight.ravel(), residual.ravel())
    pieces = per_square(fitter.sheet.evidence, weight, residual)
    free = len(fit.coordinates)
    price = np.array([0.0] * free + [PULL_PRICE] * len(fit.pulled))
    pulls = np.concatenate([np.zeros(free), fit.pulls[list(fit.pulled)]])
    wanted = -inverse_of(pieces * hessian + np.diag(price)) @ (pieces * slope + price * pulls)
    variance, count = variances(fit, fitter)
    found = set()
    for index, one in enumerate(fit.coordinates):
        name = f"{one.effect}.{one.quantity.name}"
        at = one.inward(fit.values[one.effect][one.quantity.name])
        outward = -1.0 if at - one.low < one.high - at else 1.0
        noise = quantile(count) * math.sqrt(max(float(variance[index]), 0.0))
        if name in fit.bounds_hit and outward * wanted[index] > noise:
            found.add(name)
    return frozenset(found)
