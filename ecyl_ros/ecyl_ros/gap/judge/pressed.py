"""Parameters that only the bound of their fit holds: the data press them against it.

What an effect does fades as its parameter goes to zero, and so does what a recording can say of it:
a fit in logarithms then drifts until it meets the end of its reach, and noise drove it there. The
data press only where the value that they would have without a bound is beyond it by more than the
half width of its 95 % interval.
"""

from __future__ import annotations

import numpy as np

from ..fit.fit import Fit, Fitter
from ..fit.gram import weighted_products
from ..fit.robust import per_square, robust_weights
from ..inverse import inverse_of
from .intervals import price_of, quantile, variances


def pressed(fit: Fit, fitter: Fitter) -> set[str]:
    """Those of a fit's `bounds_hit` that the data press against their bound."""
    if not fit.bounds_hit or fit.jacobian is None:
        return set(fit.bounds_hit)
    residual = fit.gap[:, fitter.rows]
    weight = robust_weights(residual)
    hessian, slope = weighted_products(fit.jacobian, weight.ravel(), residual.ravel())
    pieces = per_square(fitter.sheet.evidence, weight, residual)
    price, free = price_of(fit), len(fit.coordinates)
    pulls = np.concatenate([np.zeros(free), fit.pulls[list(fit.pulled)]])
    wanted = -inverse_of(pieces * hessian + np.diag(price)) @ (pieces * slope + price * pulls)
    variance, count = variances(fit, fitter)
    half = quantile(count) * np.sqrt(np.maximum(variance, 0.0))
    found = set()
    for index, one in enumerate(fit.coordinates):
        at = one.inward(fit.values[one.effect][one.quantity.name])
        outward = -1.0 if at - one.low < one.high - at else 1.0
        if outward * wanted[index] > half[index]:
            found.add(f"{one.effect}.{one.quantity.name}")
    return found.intersection(fit.bounds_hit)
