"""How far coefficients of a balance may be off: 95 % intervals, by noise and by what is left."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from scipy.stats import t as student

from ...arrays import BoolArray, FloatArray
from ...drive.rigid.model import Model
from ...effects.along import UNMODELLED
from ...effects.term import Interval, Parameters, Term
from ..sheet import PULL_PRICE
from .balance import Balance
from .normal import MOST_BLUR, freed
from .searched import with_searched
from .solution import Solution

_ALONG_A_WAVE = 0.5  # of `UNMODELLED`; models err smoothly, and in other directions by all of it
# Of what a fit leaves, RMS: an effort of which any share of its square may lie along the columns,
# one like another, leaves more than 1/20 of it with 95 %.
_MOST_TAKEN = math.sqrt(20.0)
_NOTHING = 1e-12  # of the variance that white noise gives
_FORM = 1e-3  # half width, as a share of the value, that no interval falls below


def covariance(balance: Balance, solution: Solution, rows: BoolArray) -> tuple[FloatArray, int]:
    """Of the coefficients fitted on `rows`, and the number of stretches that it rests on.

    The sandwich estimator over stretches: what is left may be correlated within one as it
    likes. Never less than white noise of the residual's size would give.
    """
    columns = balance.columns(solution.terms)[rows]
    weights = solution.weights[rows]
    residual = solution.residual[rows]
    inverse = _inverse(balance, solution, columns, weights)
    labels = np.unique(balance.stretch[rows], return_inverse=True)[1]
    count = int(labels.max()) + 1
    scores = np.zeros((count, columns.shape[1]))
    np.add.at(scores, labels, columns * (weights * residual)[:, None])
    meat = scores.T @ scores * (count / max(count - 1, 1))
    # What was known beforehand counts like an observation.
    meat += np.diag((solution.prior * solution.share) ** 2)
    made = inverse @ meat @ inverse
    white = inverse * solution.scale**2
    least, found = np.maximum(np.diag(white), 0.0), np.diag(made)
    # A column that nothing is left along has no spread of its own to be scaled.
    np.fill_diagonal(made, np.where(found < _NOTHING * least, least, found))
    grown = np.sqrt(np.maximum(least / np.maximum(np.diag(made), 1e-300), 1.0))
    return made * np.outer(grown, grown), count


def _inverse(
    balance: Balance, solution: Solution, columns: FloatArray, weights: FloatArray
) -> FloatArray:
    """Of the normal equations, float64[k, k]; columns, weights: float64[m, ...] of its rows."""
    gram, ridge = (columns * weights[:, None]).T @ columns, solution.prior**2 * solution.share
    return _inverted(balance, solution, gram, float(weights.sum()), ridge)


def _inverted(
    balance: Balance, solution: Solution, gram: FloatArray, weight: float, ridge: FloatArray
) -> FloatArray:
    """The same of products of columns, float64[k, k], of samples that weigh `weight` together.

    ridge: float64[k], what the square of a coefficient costs.
    """
    gram = gram + np.diag(ridge)
    blurred = balance.blurred(solution.terms)
    size = np.sqrt(np.diag(gram))
    size[size == 0.0] = 1.0
    gram -= freed(gram, blurred, weight * balance.blur.noise**2)
    scaled = gram / np.outer(size, size)
    made: FloatArray = np.linalg.pinv(scaled, hermitian=True) / np.outer(size, size)
    return made


def unsure(balance: Balance, solution: Solution, rows: BoolArray) -> FloatArray:
    """How far coefficients may be off by noise of the position, float64[k], signed.

    By the steps of the encoder: noise in a column makes its coefficient too small; how much of
    the steps is noise depends on how the motion meets them. By noise that went round the loop:
    a delay cancels some of it, and so comes out too long.
    """
    blurred = balance.blurred(solution.terms)
    columns, weights = balance.columns(solution.terms)[rows], solution.weights[rows]
    inverse = _inverse(balance, solution, columns, weights)
    more = max(balance.blur.counted**2 - balance.blur.noise**2, 0.0) * float(weights.sum())
    told = float(blurred @ inverse @ blurred)
    more = min(more, MOST_BLUR / told if told > 0.0 else 0.0)
    made: FloatArray = more * solution.inertia(balance.model) * (inverse @ blurred)
    looped = [balance.blur.looped(one.sought) if one.sought else 0.0 for one in solution.terms]
    if any(looped):
        shared = np.repeat(looped, [one.columns.shape[0] for one in solution.terms])
        made = made - float(weights.sum()) * (inverse @ shared)
    return made


def unmodelled(balance: Balance, *, wave: bool) -> float:
    """RMS of what no model explains, along one effect; wave: whether that is a sine."""
    share = UNMODELLED * (_ALONG_A_WAVE if wave else 1.0)
    return share * float(np.std(balance.effort[balance.usable]))


def _modelled(
    balance: Balance, solution: Solution, rows: BoolArray, left: float, quantile: float
) -> FloatArray:
    """Squares and products of how much further coefficients may be off, beyond `quantile` standard
    deviations of noise, by what no model explains and by what is `left`, float64[k, k].

    An effort of that RMS may lie along any of them, as far as their tolerances allow: like one
    observation of it, whatever the number of samples. A tolerance bounds what noise and that effort
    do together. What a fit leaves bounds the effort: little of it can have been taken whole.
    """
    most = _MOST_TAKEN * solution.rms(rows)
    size = np.array(
        [
            math.hypot(min(unmodelled(balance, wave=one.rate != 0.0), most), left)
            for one in solution.terms
            for _ in range(one.columns.shape[0])
        ]
    )
    columns, weights = balance.columns(solution.terms)[rows], solution.weights[rows]
    gram, weight = (columns * weights[:, None]).T @ columns, float(weights.sum())

    def off(power: FloatArray) -> FloatArray:
        """By an effort that makes the normal equations so unsure, float64[k]."""
        known = power * solution.prior**2 / PULL_PRICE
        root = np.sqrt(power)
        made: FloatArray = np.outer(root, root) * _inverted(balance, solution, gram, weight, known)
        return made

    noise = np.full(size.size, quantile**2 * solution.share)
    return off(noise + weight * size**2) - off(noise)


def half_width(
    balance: Balance, solution: Solution, rows: BoolArray, combined: FloatArray, left: float = 0.0
) -> float:
    """95 % half width of a combination of the coefficients; combined: weight of each,
    float64[k]. left: as in `intervals`."""
    spread, count = covariance(balance, solution, rows)
    quantile = _quantile(count, solution)
    parts = quantile**2 * spread + _modelled(balance, solution, rows, left, quantile)
    return math.sqrt(max(float(combined @ parts @ combined), 0.0))


def intervals(
    balance: Balance, solution: Solution, rows: BoolArray, left: float = 0.0
) -> dict[str, list[Interval]]:
    """95 % intervals of the parameters of each term, by its key; by the delta method.

    left: RMS of the structure that is still left: a further effect of that size would bend the
    values of those that were found.
    """
    told = solution.terms
    solution, searched = with_searched(solution)
    every, count = covariance(balance, solution, rows)
    bent = unsure(balance, solution, rows)
    quantile = _quantile(count, solution)
    modelled = _roots(_modelled(balance, solution, rows, left, quantile))
    own = balance.model.counted == 1.0
    deviations = _roots(every)
    gain = next((at for at, one in enumerate(_keys(solution.terms)) if one == "gain"), None)
    found: dict[str, list[Interval]] = {}
    at = 0
    for term in told:
        size = term.columns.shape[0]
        rows_of = [*range(at, at + size)]
        scaled = own and term.of_effort
        if scaled and gain is not None:
            rows_of.append(gain)
        values = solution.coefficients[rows_of]
        part = every[np.ix_(rows_of, rows_of)]
        base = _told(balance.model, term, values, scaled)
        made: list[Interval] = []
        slopes = np.zeros((len(base), len(rows_of)))
        for index in range(len(rows_of)):
            step = 1e-3 * math.sqrt(max(part[index, index], 1e-300))
            moved = values.copy()
            moved[index] += step
            for number, (_, _, value) in enumerate(_told(balance.model, term, moved, scaled)):
                slopes[number, index] = (value - base[number][2]) / step
        for number, (name, unit, value) in enumerate(base):
            off = float(slopes[number] @ bent[rows_of])
            spread = math.sqrt(max(float(slopes[number] @ part @ slopes[number]), 0.0))
            form = float(np.linalg.norm(slopes[number] * modelled[rows_of]))
            half = math.hypot(quantile * spread, form, _FORM * abs(value))
            if name in term.fixed:
                own_at = searched.get((term.key, name))
                half = 0.0  # of a whole number
                if own_at is not None:
                    half = math.hypot(quantile * deviations[own_at], modelled[own_at])
            if number == 0:
                half = math.hypot(half, term.unsure)
            low, high = value - half + min(off, 0.0), value + half + max(off, 0.0)
            made.append(Interval(name, unit, value, low, high))
        found[term.key] = made
        at += size
    return found


def _told(model: Model, term: Term, values: FloatArray, scaled: bool) -> Parameters:
    """Parameters of coefficients, float64[k]; one more is that of the gain beside them.

    scaled: counted by the true gain, not as the effort was recorded.
    """
    size = term.columns.shape[0]
    gain = model.ratio + float(values[size:].sum()) if scaled else 1.0
    return term.parameters(values[:size] / max(gain, 1e-12))


def _roots(squares: FloatArray) -> FloatArray:
    """Of the diagonal of squares and products, float64[k, k]."""
    made: FloatArray = np.sqrt(np.maximum(np.diag(squares), 0.0))
    return made


def _quantile(count: int, solution: Solution) -> float:
    """Standard deviations that 95 % of all lie within, of a fit that rests on so many stretches."""
    return float(student.ppf(0.975, max(count - solution.coefficients.size, 2)))


def _keys(terms: Sequence[Term]) -> list[str]:
    """The key of the term of each coefficient."""
    return [one.key for one in terms for _ in range(one.columns.shape[0])]
