"""The samples of a recording that answer linearly to what a fit has left open.

Where the flanks meet early or late, a sample answers with a spike: its derivative is hundreds of
noises per unit, and the unit later it is zero again. A few such samples carry nearly all of a
Gauss-Newton step's curvature, hold the step to a thousandth of its way, and make intervals as much
too narrow. Derivatives over a short and over a long step tell them from all others.
"""

from __future__ import annotations

import numpy as np

from ...arrays import BoolArray, FloatArray
from ..inverse import inverse_of
from .gram import weighted_products

_FIRST = 0.9  # of the samples, those that bend least, begin
_ROUNDS = 12  # until which samples count agrees with what they leave open
_FEW = 1e-3  # of the samples that may still change sides
_NEARLY = (
    0.25  # of its answer that a sample may bend by: a step is right to that, the next mends it
)


def linear_samples(
    tangents: FloatArray,
    secants: FloatArray,
    weights: FloatArray,
    evidence: float,
    price: FloatArray,
) -> BoolArray:
    """Which samples bend little over what all of these leave open: bool[m].

    By less than their noise, or than a part of their answer: what tells of something alone may
    answer by a lot.

    Args:
        tangents, secants: float64[k, m], derivatives of the residual, in noises, by differences
            over a short and over a long step.
        weights: float64[m], what each square counts for.
        evidence: pieces of evidence in all m. price: float64[k], of a step of one.
    """
    per_sample, bends = evidence / tangents.shape[1], tangents - secants

    def squares(counted: FloatArray) -> tuple[FloatArray, FloatArray]:
        gram, _ = weighted_products(tangents, counted, counted)
        open_ = inverse_of(per_sample * gram + np.diag(price))
        values, vectors = np.linalg.eigh(open_)
        root = vectors * np.sqrt(np.maximum(values, 0.0))
        bent, answers = (np.square(root.T @ one).sum(axis=0) for one in (bends, tangents))
        return bent, answers

    bent, _ = squares(weights)
    linear: BoolArray = bent <= np.quantile(bent, _FIRST)
    for _ in range(_ROUNDS):
        bent, answers = squares(weights * linear)
        now: BoolArray = bent < np.maximum(1.0, _NEARLY**2 * answers)
        settled = np.count_nonzero(now != linear) <= _FEW * linear.size
        linear = now
        if settled:
            break
    return linear
