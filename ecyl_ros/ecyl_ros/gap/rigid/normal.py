"""Weighted least squares by normal equations that are freed of noise in their columns.

Noise of the acceleration makes an inertia too small; how much of it there is is known, and is taken
out of both sides.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import lsq_linear, nnls

from ...arrays import FloatArray

_TOLD = 1e-12  # of the largest eigenvalue
MOST_BLUR = 0.5  # of what is known of the acceleration that noise may have brought


def freed(gram: FloatArray, blurred: FloatArray, noise: float) -> FloatArray:
    """What noise of the acceleration adds to normal equations, float64[k, k].

    No more of it than half of what they say of the acceleration. noise: its square, summed.
    """
    if not (noise > 0.0 and blurred.any()):
        return np.zeros_like(gram)
    values, vectors = np.linalg.eigh(gram)
    told_by = values > len(gram) * np.finfo(float).eps * values[-1]
    along = (blurred @ vectors)[told_by]
    told = noise * float(along @ (along / values[told_by]))
    share = noise * min(1.0, MOST_BLUR / max(told, 1e-300))
    made: FloatArray = (share * blurred)[:, None] * blurred
    return made


def solve(
    columns: FloatArray,
    target: FloatArray,
    weights: FloatArray,
    bounds: tuple[FloatArray, FloatArray],
    ridge: FloatArray,
    blurred: FloatArray,
    noise: tuple[float, float],
) -> FloatArray:
    """Weighted least squares within bounds, by normal equations of scaled columns.

    columns: float64[k, m]. target, weights: float64[m]. bounds: of the coefficients, float64[k]
    each, low and high. ridge: float64[k], what the square of a coefficient costs beside the squared
    residuals. blurred: float64[k], share of the acceleration in each column, whose noise is taken
    out of both sides; noise: its size, and the inertia by which the target holds it.
    """
    # With its price, so that a column that hardly moves and must not does not dwarf the others.
    count = max(target.size, 1)
    size = np.sqrt((np.einsum("km,km->k", columns, columns) + ridge) / count)
    size[size == 0.0] = 1.0
    weighted = columns * weights
    gram = (weighted @ columns.T) / (size[:, None] * size)
    gram.flat[:: size.size + 1] += ridge / size**2
    aim = weighted @ target / size
    if blurred.any():
        share = blurred / size
        brought = freed(gram, share, float(weights.sum()) * noise[0] ** 2)
        gram -= brought
        aim += noise[1] * brought @ share / float(share @ share)
    values, vectors = np.linalg.eigh(gram)
    aimed = aim @ vectors
    # Directions that nothing tells of are left out, as least squares does.
    told = np.abs(values) > _TOLD * np.abs(values).max(initial=0.0)
    found: FloatArray = vectors[:, told] @ (aimed[told] / values[told]) / size
    low, high = bounds
    if (found >= low).all() and (found <= high).all():
        return found
    # The same minimum as of the tall problem: gram = L L', aim = L y.
    root = np.sqrt(np.maximum(values, _TOLD * values[-1]))
    system, aim = root[:, None] * vectors.T, aimed / root
    if np.isfinite(high).any():
        within: FloatArray = (
            lsq_linear(system, aim, (low * size, high * size), method="bvls").x / size
        )
        return within
    # What is bounded is counted from its bound; what is free is the difference of two parts.
    floor = np.where(np.isfinite(low), low * size, 0.0)
    free = np.flatnonzero(~np.isfinite(low))
    parts, _ = nnls(np.concatenate([system, -system[:, free]], axis=1), aim - system @ floor)
    scaled_found = floor + parts[: low.size]
    scaled_found[free] -= parts[low.size :]
    result: FloatArray = scaled_found / size
    return result
