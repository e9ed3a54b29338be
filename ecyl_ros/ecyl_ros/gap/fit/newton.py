"""Gauss-Newton with Cauchy's weights and a price on some of the coordinates.

The objective is the logarithm of a robust mean square, times the pieces of evidence behind it, plus
the price: with the level of what is left unknown, this is twice a negative log likelihood. Steps
are damped where they leave more (Levenberg).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import LinAlgError, cho_factor, cho_solve

from ...arrays import FloatArray
from ..side_by_side import side_by_side
from .gram import weighted_products
from .robust import robust_mean_square, robust_weights

# Levenberg's damping, tried in turn until a step leaves less; steps that come near need none.
_DAMPING = (0.0, 1e-2, 0.1, 1.0, 10.0)
_KEPT_PROMISE = 0.75  # share of the promised fall from which derivatives that last are kept
_GOOD_STEP = 0.25  # share of the promised fall from which the next damping is not tried
_SLOW = 0.5  # of the last step's promise: near its end a fit promises less and less
_LONGEST = 64.0  # times a step, doubled as long as that leaves less


@dataclass(frozen=True, eq=False)
class Objective:
    """What is brought down.

    Attributes:
        residual: float64[...] of the replay at a point float64[k]. tried: the same of a step that
            may be taken, for the caller to keep what it is like.
        seen: float64[m] that counts of a residual, linear in it; all of it where there is none.
        loss_scale: of Cauchy's loss. evidence: pieces of evidence in the residual.
        precision: float64[k], of the price: point^2 times it.
        low, high: float64[k], bounds.
    """

    residual: Callable[[FloatArray], FloatArray]
    tried: Callable[[FloatArray], FloatArray]
    loss_scale: float
    evidence: float
    precision: FloatArray
    low: FloatArray
    high: FloatArray
    seen: Callable[[FloatArray], FloatArray] | None = None

    def value(self, residual: FloatArray, point: FloatArray) -> float:
        """At a point with its residual."""
        level = robust_mean_square(self._seen(residual), self.loss_scale)
        return self.evidence * math.log(level) + float(self.precision @ point**2)

    def curvature(
        self, residual: FloatArray, point: FloatArray, slopes: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """(float64[k, k] without the price, float64[k] with it): of half the objective."""
        left = self._seen(residual)
        weights = robust_weights(left, self.loss_scale)
        level = robust_mean_square(left, self.loss_scale)
        scale = self.evidence / (level * left.size)
        hessian, slope = weighted_products(self._slopes_seen(slopes), weights, left)
        return scale * hessian, scale * slope + self.precision * point

    def _seen(self, residual: FloatArray) -> FloatArray:
        return residual if self.seen is None else self.seen(residual)

    def _slopes_seen(self, slopes: FloatArray) -> FloatArray:
        return slopes if self.seen is None else np.stack([self.seen(one) for one in slopes])


@dataclass(frozen=True)
class Differences:
    """How derivatives are taken: steps float64[k], both ways if central."""

    steps: FloatArray
    central: bool


def descend(
    objective: Objective,
    point: FloatArray,
    slopes: FloatArray,
    wanted: Sequence[int],
    lasting: Collection[int],
    differences: Differences,
    *,
    most: int,
    least: float,
    fresh: bool = True,
    mended: Callable[[FloatArray, FloatArray], None] | None = None,
) -> bool:
    """Go down from `point`, with at most `most` steps; returns whether it has ended.

    Args:
        objective: what is brought down.
        point: float64[k], to begin at.
        slopes: float64[k, ...], derivatives of the residual; overwritten where `wanted`.
        wanted: coordinates whose derivatives are to be worked out; the others' are kept.
        lasting: those of `wanted` that the residual depends on nearly linearly: their derivatives
            are worked out again only after a step that did not keep its promise.
        differences: how.
        most: steps at the most.
        least: fall of the objective below which it has ended.
        fresh: whether derivatives that last are worked out at first; else those in `slopes` go on.
        mended: takes derivatives and the point they are of, and puts right what is known of them.
    """
    residual = objective.tried(point)
    value = objective.value(residual, point)
    fleeting = [one for one in wanted if one not in lasting]
    before = math.inf
    for _ in range(most):
        todo = wanted if fresh else fleeting
        differentiate(objective, point, residual, slopes, todo, differences)
        if mended is not None:
            mended(slopes, point)
        hessian, slope = objective.curvature(residual, point, slopes)
        gained, promised, there, left = 0.0, 0.0, point, residual
        for damping in _DAMPING:
            moved, fall = _step(objective, hessian, slope, point, damping)
            after = objective.tried(moved)
            gain = value - objective.value(after, moved)
            promised = max(promised, fall)
            if gain > gained:
                gained, there, left = gain, moved, after
            if gained > 0.0 and gained >= _GOOD_STEP * fall:
                break
        if gained <= least and (fresh or promised <= least):
            return True
        if gained > 0.0 and promised > _SLOW * before:
            there, left, reached = _further(objective, point, there, left, value - gained)
            gained = value - reached
        before = promised
        fresh = gained < _KEPT_PROMISE * promised
        point, residual, value = there, left, value - gained
    return False


def _further(
    objective: Objective, point: FloatArray, there: FloatArray, left: FloatArray, value: float
) -> tuple[FloatArray, FloatArray, float]:
    """The best of longer steps the same way, its residual, and the objective there.

    there, left, value: those of the step.

    Spikes in a derivative that do not overlap those that are left make its curvature too large:
    step after step is too short.
    """
    step, length = there - point, 2.0
    while length <= _LONGEST:
        moved = np.clip(point + length * step, objective.low, objective.high)
        after = objective.tried(moved)
        other = objective.value(after, moved)
        if not other < value:
            break
        there, left, value = moved, after, other
        length *= 2.0
    return there, left, value


def differentiate(
    objective: Objective,
    point: FloatArray,
    residual: FloatArray,
    slopes: FloatArray,
    wanted: Sequence[int],
    differences: Differences,
) -> None:
    """Put derivatives of the residual at a point, where it is `residual`, into `slopes`."""
    turns = np.where(
        point + differences.steps > objective.high, -differences.steps, differences.steps
    )

    def slope(index: int) -> FloatArray:
        moved = point.copy()
        moved[index] += turns[index]
        ahead = objective.residual(moved)
        if not differences.central:
            return (ahead - residual) / turns[index]
        moved[index] -= 2.0 * turns[index]
        return (ahead - objective.residual(moved)) / (2.0 * turns[index])

    for index, found in zip(wanted, side_by_side(slope, wanted), strict=True):
        slopes[index] = found


def _step(
    objective: Objective,
    hessian: FloatArray,
    slope: FloatArray,
    point: FloatArray,
    damping: float,
) -> tuple[FloatArray, float]:
    """Where a damped step from `point` leads within the bounds, and the fall that it promises."""
    size = np.diag(hessian) + objective.precision
    size = np.where(size > 0.0, size, 1.0)
    # Scaled by its own curvature; what nothing depends on stays where it is.
    root = 1.0 / np.sqrt(size)
    whole = hessian + np.diag(objective.precision)
    full = whole * np.outer(root, root)
    full[np.diag_indices_from(full)] += damping + 1e-9
    try:
        step = -root * cho_solve(cho_factor(full), root * slope)
    except LinAlgError:
        return point, 0.0
    reached = np.clip(point + step, objective.low, objective.high)
    step = reached - point
    fall = -2.0 * float(slope @ step) - float(step @ whole @ step)
    return reached, max(fall, 0.0)
