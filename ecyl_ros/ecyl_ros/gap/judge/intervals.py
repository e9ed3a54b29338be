"""95 % intervals of fitted parameters that hold although what is left of the gap is not white.

The constants of the data sheet are fitted beside them: what is not known of these widens the
intervals of what they can be exchanged for.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.stats import t as student

from ...arrays import BoolArray, FloatArray
from ...drive.tolerances import CONSTANTS
from ...effects.catalogue import CATALOGUE
from ..fit.coordinate import Coordinate
from ..fit.fit import Fit, Fitter
from ..fit.gram import weighted_products
from ..fit.robust import per_square, robust_weights
from ..inverse import inverse_of
from ..sheet import PULL_PRICE
from ..split import stretch_of

# Half width, as a share of the value, that no interval falls below: the effect's form and the
# nominal values beside it are not known better; with this 96 % of the sealed study's hold.
FORM = 4e-3

_SHOWN = 1e-3  # the same of what a recording shows as it is: the digits of a log


def spreads(
    jacobian: FloatArray,
    gap: FloatArray,
    rows: BoolArray,
    time_s: FloatArray,
    evidence: float,
    price: FloatArray,
) -> tuple[FloatArray, int]:
    """Covariances of what was fitted, float64[3, k, k], and how many stretches they rest on.

    The first is the sandwich estimator over stretches of the recording: within a stretch the
    residual may be correlated as it likes. The second is what white noise at the floor would give;
    the third weighs the sheet as the fit does: what the sheet alone can tell from one another hangs
    on derivatives that no differences give well enough. No variance is less than any of them says.

    Args:
        jacobian: float64[k, signals * rows]. gap: float64[signals, n]. rows: bool[n], the fitted.
        evidence: independent pieces of it. price: float64[k], of a step of one, as a measurement of
            its own: of pulls the sheet's, 0 of what is free.
    """
    residual = gap[:, rows]
    weight = robust_weights(residual)
    hessian, _ = weighted_products(jacobian, weight.ravel(), residual.ravel())
    own = np.diag(price)
    pieces = per_square(evidence, weight, residual)
    weighed = inverse_of(pieces * hessian + own)
    inverse = inverse_of(hessian + own)
    stretch = stretch_of(time_s[rows])
    pushed = jacobian * (weight * residual).ravel()  # what each sample asks of each coordinate
    scores = pushed.reshape(len(jacobian), gap.shape[0], -1).sum(axis=1)
    labels = np.unique(stretch)
    summed = np.array([scores[:, stretch == label].sum(axis=1) for label in labels])
    count = len(labels)
    correction = count / max(count - 1, 1)
    sandwich = inverse @ (correction * summed.T @ summed + own) @ inverse
    return np.stack([sandwich, inverse, weighed]), count


def price_of(fit: Fit) -> FloatArray:
    """Of a step of one in each of a fit's coordinates (0) and pulls, float64[k]."""
    return np.array([0.0] * len(fit.coordinates) + [PULL_PRICE] * len(fit.pulled))


def variances(fit: Fit, fitter: Fitter) -> tuple[FloatArray, int]:
    """Variance of each of the fit's coordinates and pulls, and how many stretches it rests on."""
    if fit.jacobian is None:
        return np.zeros(0), 0
    evidence, time_s = fitter.sheet.evidence, fitter.replay.time_s
    found, count = spreads(fit.jacobian, fit.gap, fitter.rows, time_s, evidence, price_of(fit))
    each = np.diagonal(found, axis1=1, axis2=2)
    variance: FloatArray = each.max(axis=0) if len(fit.pulled) else each[:2].max(axis=0)
    return variance, count


def quantile(stretches: int) -> float:
    """Half the width of a 95 % interval, in standard deviations known from so many stretches."""
    return float(student.ppf(0.975, max(stretches - 1, 2)))


def _form(effect: str) -> float:
    """`FORM`, or what data sheets know the effect's constant by where that is closer (a lead)."""
    default = CONSTANTS.get(CATALOGUE[effect].constant or "")
    return FORM if default is None or default.relative == 0.0 else min(FORM, default.relative)


def _left_open(effect: str, fitter: Fitter) -> float:
    """Half width that an effect's interval does not fall below, in the unit of its parameter.

    Tolerance of the constant that it comes on top of: a healthy machine may have so much more or
    less of it; what the effect adds is not known better. Else its form, commonly 0.
    """
    one, sheet = CATALOGUE[effect], fitter.sheet
    row = sheet.index(one.constant)
    if row is not None and one.on_top:
        return float(sheet.tolerance[row])
    return one.form(fitter.replay.drive)


def _ends(one: Coordinate, value: float, half: float) -> tuple[float, float]:
    """The interval about a value, half its width in the coordinate."""
    if one.logarithmic and one.quantity.low == 0.0 and half > 1.0:
        # What it does grows in proportion near 0, and value x (1 - half) is below 0 already: the
        # value is not told from 0, and its logarithm says nothing.
        return 0.0, value * (1.0 + half)
    half, raw = min(half, 50.0), one.of(value)
    return one.outward(raw - half), one.outward(raw + half)


def intervals(
    fit: Fit, fitter: Fitter
) -> tuple[dict[tuple[str, str], tuple[float, float]], FloatArray]:
    """95 % intervals of what was fitted.

    Returns ({(effect, parameter): (low, high)}, half widths of the pulls float64[k], that of the
    sheet where a constant was not fitted).
    """
    spread, count = variances(fit, fitter)
    found = {}
    wide = quantile(count)
    for index, one in enumerate(fit.coordinates):
        value = fit.values[one.effect][one.quantity.name]
        share = _form(one.effect)
        form = share if one.logarithmic else share * abs(value) / one.scale
        half = math.hypot(wide * math.sqrt(max(float(spread[index]), 0.0)), form)
        low, high = _ends(one, value, half)
        open_ = _left_open(one.effect, fitter)
        if open_ > 0.0:
            middle, half = 0.5 * (low + high), 0.5 * abs(high - low)
            low, high = middle - math.hypot(half, open_), middle + math.hypot(half, open_)
        found[one.effect, one.quantity.name] = (
            max(min(low, high), one.quantity.low),
            min(max(low, high), one.quantity.high),
        )
    for name in fit.names:
        for parameter, value in fitter.shown(name).items():
            off = _SHOWN * abs(value)
            found[name, parameter] = value - off, value + off
    pulls = np.ones(len(fit.pulls))
    for row, variance in zip(fit.pulled, spread[len(fit.coordinates) :], strict=True):
        pulls[row] = min(1.96 * math.sqrt(max(float(variance), 0.0)), 1.0)
    return found, pulls
