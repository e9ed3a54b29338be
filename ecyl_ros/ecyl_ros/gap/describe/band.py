"""How well a law is known that was fitted in closed loop: its 95 % band, and what is left of each
stretch where the others alone tell."""

from __future__ import annotations

import numpy as np

from ...arrays import BoolArray, FloatArray
from ...drive.law import Law
from ..fit.fit import Fitter
from ..fit.linear import linear_samples
from ..fit.robust import per_square, robust_weights
from ..inverse import inverse_of
from ..judge.intervals import FORM, quantile, spreads
from ..split import stretch_of
from .guess import Guess


def linear_of(
    gap: FloatArray,
    tangents: FloatArray,
    secants: FloatArray,
    price: FloatArray,
    fitter: Fitter,
) -> BoolArray:
    """Which fitted samples of each signal answer linearly, bool[signals, rows]; see `fit.linear`.

    gap: float64[signals, n]. tangents, secants: float64[k, signals, n], its derivatives.
    price: float64[k].
    """
    weights = robust_weights(gap[:, fitter.rows])
    short, long = (one[:, :, fitter.rows].reshape(len(one), -1) for one in (tangents, secants))
    found = linear_samples(short, long, weights.ravel(), fitter.sheet.evidence, price)
    return found.reshape(weights.shape)


def half_widths(
    law: Law,
    gap: FloatArray,
    slopes: FloatArray,
    along: FloatArray,
    price: FloatArray,
    guess: Guess,
    fitter: Fitter,
) -> tuple[FloatArray, FloatArray]:
    """Half the widths of the 95 % bands of values and pulls.

    Along the directions that the law moved, from the replays; across them from the regression.

    Args:
        law: as it was fitted. gap: float64[signals, n], what it leaves, in noise floors.
        slopes: float64[k, signals x fitted rows], its derivatives.
        along: float64[m, values], what the law moved along. price: float64[k], of a step of one.
        guess: as it was regressed. fitter: of the recording.
    """
    count, time_s = len(along), fitter.replay.time_s
    spread, stretches = spreads(slopes, gap, fitter.rows, time_s, fitter.sheet.evidence, price)
    moved = np.einsum("ik,sij,jk->sk", along, spread[:, :count, :count], along).max(axis=0)
    across = np.eye(along.shape[1]) - np.linalg.pinv(along) @ along
    stayed = np.einsum("ki,ij,kj->k", across, guess.found.covariance, across)
    variance = np.maximum(moved, 0.0) + np.maximum(stayed, 0.0)
    own = np.maximum(np.diagonal(spread, axis1=1, axis2=2).max(axis=0)[count:], 0.0)
    half = np.hypot(quantile(stretches) * np.sqrt(variance), FORM * np.abs(law.values))
    return half, 1.96 * np.sqrt(own)


def unseen(gap: FloatArray, slopes: FloatArray, price: FloatArray, fitter: Fitter) -> FloatArray:
    """The gap on each fitted stretch as the others alone would leave it, beside the held-out ones.

    Without a stretch the fit moves by a Newton step from where it is. Arguments as above.
    """
    rows = fitter.rows
    stretch = stretch_of(fitter.replay.time_s[rows])
    seen = gap[:, rows]
    shape = (len(slopes), *seen.shape)
    weight = robust_weights(seen)
    pieces = per_square(fitter.sheet.evidence, weight, seen)
    found = seen.copy()
    parts = []
    for one in np.unique(stretch):
        chosen = stretch == one
        slope = slopes.reshape(shape)[:, :, chosen].reshape(len(slopes), -1)
        pushed = slope * weight[:, chosen].ravel()
        parts.append((chosen, slope, pushed @ slope.T, pushed @ seen[:, chosen].ravel()))
    whole = sum(part[2] for part in parts)
    for chosen, slope, own, force in parts:
        step = inverse_of(pieces * (whole - own) + np.diag(price)) @ (pieces * force)
        found[:, chosen] += (step @ slope).reshape(len(seen), -1)
    everywhere = gap.copy()
    everywhere[:, rows] = found
    return everywhere
