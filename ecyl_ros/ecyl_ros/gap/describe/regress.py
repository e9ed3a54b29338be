"""Laws of one or two variables regressed on what a balance leaves, judged stretch by stretch.

Each stretch of the recording is predicted from the others (cross-validation): the smoothness of a
law, and what it depends on, are those that predict best. The constants of the sheet are free beside
it at their price, weighed as everywhere else (`sheet`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...arrays import FloatArray
from ..inverse import inverse_of
from ..sheet import PULL_PRICE, raised

# Smoothness that is tried, as the weight of the roughness over that of a squared residual.
SMOOTH = 10.0 ** np.arange(-5.0, 4.0)
_ROUNDS = 4  # until level and fit agree
_LEAST = 1e-6  # squared noises: what is predicted better than noise says that there is less of it


@dataclass(frozen=True, eq=False)
class Rows:
    """What is regressed.

    Attributes:
        target: float64[m], in units of its noise. sheet: float64[k, m], of pulls of 1.
        block: int64[m], the stretch each row lies in, 0, 1, ...
        weight: float64[m], what the square of a row's error counts for.
        evidence: independent pieces of evidence in the rows.
        growth: float64[k], by what the logarithm of the noise grows with a pull of 1.
    """

    target: FloatArray
    sheet: FloatArray
    block: np.ndarray
    weight: FloatArray
    evidence: float
    growth: FloatArray


@dataclass(frozen=True, eq=False)
class Regression:
    """A law regressed on rows.

    Attributes:
        errors: float64[blocks], squared errors of prediction of each stretch, summed. count:
            int64[blocks], its rows.
        values: float64[k], of the law. pulls: float64[p]. smooth: the weight chosen.
        freedom: effective number of parameters of the law.
        stiff: what a unit of the values' roughness costs, where a pull of 1 costs 4.
        covariance: float64[k, k], of the values.
        left: float64[m], what each row lacks of its prediction, in units of its noise; rows that
            count less are smaller by the root of their weight. block: int64[m], as in `Rows`.
        price: of the pulls, by which the logarithm of an
            error counts as larger: a sheet bent by tens of tolerances predicts anything.
    """

    errors: FloatArray
    count: np.ndarray
    values: FloatArray
    pulls: FloatArray
    smooth: float
    freedom: float
    stiff: float
    covariance: FloatArray
    left: FloatArray
    block: np.ndarray
    price: float = 0.0

    @property
    def error(self) -> float:
        """See `typical`; raised by the price of the pulls, as in `sheet`."""
        return raised(typical(self.errors, self.count), self.price)


def typical(errors: FloatArray, count: np.ndarray) -> float:
    """Mean square error of prediction in squared noises, the geometric mean over the stretches.

    errors: float64[blocks], sums of squares. count: int64[blocks], of what. One stretch that leads
    where no other went, or in which much happened, does not decide.
    """
    used = count > 0
    # Of normal equations a sum of squares may come out below 0 by rounding.
    logarithms = np.log1p(np.maximum(errors[used], 0.0) / count[used])
    return float(np.expm1(np.average(logarithms, weights=count[used])))


class Normal:
    """Normal equations of rows and a law, stretch by stretch."""

    def __init__(self, rows: Rows, law: FloatArray, rough: FloatArray) -> None:
        self.rows, self.size = rows, len(law)
        root = np.sqrt(rows.weight)
        self.design = design = np.concatenate([law, rows.sheet]) * root
        self.target = rows.target * root
        blocks = int(rows.block.max()) + 1
        whole = len(design)
        self.gram = np.zeros((blocks, whole, whole))
        self.slope = np.zeros((blocks, whole))
        self.square = np.zeros(blocks)
        self.count = np.bincount(rows.block, minlength=blocks)
        for one in range(blocks):
            chosen = rows.block == one
            part, target = design[:, chosen], self.target[chosen]
            self.gram[one] = part @ part.T
            self.slope[one] = part @ target
            self.square[one] = target @ target
        self.rough = np.zeros((whole, whole))
        self.rough[: self.size, : self.size] = rough
        # Roughness is weighed against how much the rows say of a value on average.
        scale = np.trace(self.gram.sum(axis=0)[: self.size, : self.size]) / max(self.size, 1)
        self.scale = float(scale) if scale > 0.0 else 1.0
        self.rough *= self.scale
        self.price = np.zeros((whole, whole))
        held = np.arange(self.size, whole)
        self.price[held, held] = PULL_PRICE
        self.growth = np.concatenate([np.zeros(self.size), rows.growth])

    def held(self, smooth: float, level: float) -> FloatArray:
        """What is added to the normal equations; level: mean square error."""
        weight = level * self.count.sum() / self.rows.evidence
        found: FloatArray = smooth * self.rough + weight * self.price
        return found

    def grown(self, square: float) -> FloatArray:
        """What is added to the right of the normal equations: float64[k + p].

        A row counts in units of its noise, which grows with the constants: else all torques smaller
        by one factor would leave less, and what is left of one law would be taken for another's.
        square: of what is left, summed.
        """
        found: FloatArray = square * self.growth
        return found

    def without(self, smooth: float, level: float, folds: Sequence[np.ndarray]) -> FloatArray:
        """What is found without each fold: float64[folds, k + p]."""
        added = self.held(smooth, level)
        gram = self.gram.sum(axis=0) + added
        right = self.slope.sum(axis=0) + self.grown(level * float(self.count.sum()))
        left = np.stack([gram - self.gram[fold].sum(axis=0) for fold in folds])
        index = np.arange(left.shape[1])
        left[:, index, index] *= 1.0 + 1e-9
        left[:, index, index] += 1e-12
        rights = np.stack([right - self.slope[fold].sum(axis=0) for fold in folds])
        solved: FloatArray = np.linalg.solve(left, rights[:, :, None])[:, :, 0]
        return solved

    def predict(self, found: FloatArray, folds: Sequence[np.ndarray]) -> FloatArray:
        """Squared errors of prediction by stretch, float64[blocks]; found: see `without`."""
        errors = np.zeros(len(self.count))
        for fold, one in zip(folds, found, strict=True):
            for block in fold:
                spread = self.gram[block] @ one - 2.0 * self.slope[block]
                errors[block] = self.square[block] + float(one @ spread)
        return errors

    def left(self, found: FloatArray, folds: Sequence[np.ndarray]) -> FloatArray:
        """What each row lacks of its prediction, float64[m]; found: see `without`."""
        missed = self.target.copy()
        for fold, one in zip(folds, found, strict=True):
            rows = np.isin(self.rows.block, fold)
            missed[rows] -= one @ self.design[:, rows]
        return missed


def folds_of(rows: Rows, most: int = 6) -> list[np.ndarray]:
    """Stretches that are left out together."""
    blocks = np.unique(rows.block)
    count = min(most, len(blocks))
    return [blocks[blocks % count == one] for one in range(count)]


def regress(
    rows: Rows,
    law: FloatArray,
    rough: FloatArray,
    level: float,
    *,
    choices: FloatArray = SMOOTH,
    rounds: int = _ROUNDS,
) -> Regression:
    """The law of that smoothness, of `choices`, that predicts best.

    level: typical square error to begin with.
    """
    normal = Normal(rows, law, rough)
    folds = folds_of(rows)
    choices = choices if normal.size > 1 else choices[:1]
    best_errors, best_found, best = None, None, float(choices[0])
    for _ in range(rounds):
        tried = {float(one): normal.without(float(one), level, folds) for one in choices}
        errors = {one: normal.predict(found, folds) for one, found in tried.items()}
        best = min(errors, key=lambda one: typical(errors[one], normal.count))
        best_errors, best_found = errors[best], tried[best]
        now = max(typical(best_errors, normal.count), _LEAST)
        if now > 0.7 * level:
            break
        level = max(now, 0.1 * level)
    assert best_errors is not None and best_found is not None
    whole = normal.gram.sum(axis=0)
    inverse = inverse_of(whole + normal.held(best, level))
    right = normal.slope.sum(axis=0)
    square = level * float(normal.count.sum())
    found = inverse @ (right + normal.grown(square))
    left = float(normal.square.sum() + found @ (whole @ found - 2.0 * right))
    found = inverse @ (right + normal.grown(max(left, 0.0)))
    size = normal.size
    freedom = float(np.trace((inverse @ whole)[:size, :size]))
    stiff = best * normal.scale * rows.evidence / square
    pulls = found[size:]
    return Regression(
        best_errors,
        normal.count,
        found[:size],
        pulls,
        best,
        freedom,
        stiff,
        level * inverse[:size, :size],
        normal.left(best_found, folds),
        rows.block,
        PULL_PRICE * float(pulls @ pulls) / rows.evidence,
    )
