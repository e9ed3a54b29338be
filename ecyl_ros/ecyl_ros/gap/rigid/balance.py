"""The balance of efforts as a robust regression: columns in, coefficients and residual out."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import lsq_linear

from ...arrays import BoolArray, FloatArray
from ...drive.rigid.model import Model
from ...effects.term import Term
from ...typical import typical_rms
from ..fit.robust import robust_squares, robust_weights
from ..sheet import EVIDENCE_PER_S
from ..split import STRETCH_S
from .motion import Motion
from .normal import solve
from .rest import at_rest
from .solution import Solution

HELD_OUT_EVERY = 3  # one stretch in so many is never fitted
MOST_STRETCHES = 48  # what is left is correlated over time: more of them say no more
_ROUNDING = 1e-12  # of the effort
_LOSS = 5.0  # residuals beyond so many robust standard deviations lose their weight (Cauchy)
ROUNDS = 6
# Motion with which rest is left out: at 25 samples a second that say something of their own, four
# for each coefficient of the largest sets; of a short recording this share.
_LEAST_MOVING_S, _LEAST_MOVING = 2.0, 0.2
_REMEMBERED = 512  # fits that are kept, of some thousand


class Blur(NamedTuple):
    """Noise of the acceleration, which regressions have to be freed of.

    noise: standard deviation within the band that is sure. counted: that with the steps of the
    encoder. looped: by the seconds of a delay, covariance of what this noise leaves with the
    delay's column; 0 unless the noise goes round a loop.
    """

    noise: float = 0.0
    counted: float = 0.0
    looped: Callable[[float], float] = lambda delay_s: 0.0


class _Found(NamedTuple):
    """What a fit finds: coefficients, float64[k], and the scale and share of a `Solution`.

    terms: those that follow what is explained; they are told by who they are, so they are kept.
    """

    coefficients: FloatArray
    scale: float
    share: float
    terms: tuple[Term, ...]


class Balance:
    """Measured effort less what the nominal model asks, and what may explain the rest.

    Attributes:
        target: float64[m], effort less nominal, filtered. effort: float64[m].
        usable, held: bool[m]. stretch: int64[m], number of the stretch of `stretch_s`.
        lag_s: see below. moves: whether it moves for long enough to be judged by that alone.
        fold: int64[m], 0 to `FOLDS` - 1 on stretches that are fitted, for cross-validation.
    """

    FOLDS = 4

    def __init__(
        self,
        motion: Motion,
        nominal: FloatArray,
        model: Model,
        blur: Blur | None = None,
        lag_s: float = 0.0,
    ) -> None:
        """nominal: float64[n], what `model` asks for. lag_s: by which the effort was recorded ahead
        of the motion."""
        self.motion, self.model, self.lag_s = motion, model, lag_s
        self.blur = blur or Blur()
        self.nominal = nominal
        self.effort = motion.shifted(motion.effort, np.array([lag_s]))[0]
        self.target = self.effort - motion.filtered(nominal)
        rows = motion.rows
        self.time_s = motion.time_s[rows]
        moving = (motion.usable & ~at_rest(motion))[rows]
        # Where it hardly ever moves there is nothing else to go by.
        enough = min(
            _LEAST_MOVING_S * self._rate,
            _LEAST_MOVING * max(motion.usable[rows].sum(), 1),
        )
        self.moves = bool(moving.sum() >= enough)
        self.usable: BoolArray = moving if self.moves else motion.usable[rows]
        part = self.time_s[self.usable]
        begin, end = (float(part[0]), float(part[-1])) if part.size else (0.0, 1.0)
        self.stretch_s = stretch_length(end - begin, float(self.usable.sum()) / self._rate)
        self.stretch: NDArray[np.int64] = np.floor((self.time_s - begin) / self.stretch_s).astype(
            np.int64
        )
        self.held: BoolArray = self.stretch % HELD_OUT_EVERY == 1
        self.fold: NDArray[np.int64] = self.stretch // HELD_OUT_EVERY % self.FOLDS
        self._cache: dict[str, tuple[Term, FloatArray]] = {}
        self._fits: dict[tuple, _Found] = {}

    @property
    def fitted(self) -> BoolArray:
        """Rows that parameters are fitted to."""
        return self.usable & ~self.held

    @property
    def judged(self) -> BoolArray:
        """Rows that no parameter is fitted to."""
        return self.usable & self.held

    def columns(self, terms: Sequence[Term]) -> FloatArray:
        """float64[m, k], filtered."""
        if not terms:
            return np.zeros((self.target.size, 0))
        return np.concatenate(self._parts(terms)).T

    def _parts(self, terms: Sequence[Term]) -> list[FloatArray]:
        """The columns of each term, float64[k, m] each."""
        made = []
        for one in terms:
            # Columns that follow what is explained so far may be others of the same key.
            last = self._cache.get(one.key)
            if last is None or (last[0] is not one and one.follows):
                last = self._cache[one.key] = (one, self.motion.filtered(one.columns))
            made.append(last[1])
        return made

    def fit(
        self,
        terms: Sequence[Term],
        rows: BoolArray | None = None,
        rounds: int = ROUNDS,
        prior: FloatArray | None = None,
        begin: Solution | None = None,
    ) -> Solution:
        """Robust least squares (Cauchy loss by reweighting) within the terms' bounds.

        prior: see `Solution`; the price of a data sheet, (2 pull)^2, against the evidence of the
        recording (see `gap.sheet`). begin: a fit of the same set to all rows that are fitted, whose
        weights come first; equal weights else.
        """
        rows = self.fitted if rows is None else rows
        parts = self._parts(terms)
        prior = np.zeros(sum(map(len, parts))) if prior is None else prior
        # Competing sets come up again and again.
        of = tuple(
            (one.key, id(one) if one.follows else 0, one.low, one.high, one.inertia)
            for one in terms
        )
        asked = (of, rows.tobytes(), rounds, prior.tobytes(), begin is None)
        found = self._fits.get(asked)
        if found is None:
            if len(self._fits) == _REMEMBERED:
                del self._fits[next(iter(self._fits))]
            found = self._fits[asked] = self._found(terms, parts, rows, rounds, prior, begin)
        residual, at = self.target.copy(), 0
        for one in parts:
            residual -= found.coefficients[at : at + len(one)] @ one
            at += len(one)
        weights = robust_weights(residual, _LOSS * found.scale) if terms else np.ones(residual.size)
        evidence = max(float(rows.sum()) * min(EVIDENCE_PER_S / self._rate, 1.0), 1.0)
        return Solution(
            tuple(terms),
            found.coefficients,
            residual,
            weights,
            found.scale,
            prior,
            found.share,
            evidence,
        )

    def _found(
        self,
        terms: Sequence[Term],
        parts: Sequence[FloatArray],
        rows: BoolArray,
        rounds: int,
        prior: FloatArray,
        begin: Solution | None,
    ) -> _Found:
        """Coefficients by some rows alone; parts: columns of each term, float64[k, m]."""
        target = self.target[rows]
        # What is less than the effort's rounding is no scale for anything.
        least = max(_ROUNDING * _rms(self.effort), 1e-300)
        if begin is None:
            weights, scale = np.ones(target.size), max(_scale(target), least)
        else:
            weights, scale = begin.weights[rows], begin.scale
        share = 0.0
        coefficients = np.zeros(prior.size)
        if terms:
            low = np.array([value for one in terms for value in one.low])
            high = [value for one in terms for value in one.high or [math.inf] * len(one.low)]
            bounds, blurred = (low, np.array(high)), self.blurred(terms)
            at = np.flatnonzero(rows)  # taken from in a third of the time that a mask takes
            columns = np.concatenate([one.take(at, axis=1) for one in parts])
            for _ in range(rounds):
                share = scale**2 * max(self._rate / EVIDENCE_PER_S, 1.0)
                ridge = prior**2 * share
                coefficients = solve(columns, target, weights, bounds, ridge, blurred, self._noise)
                residual = target - coefficients @ columns
                scale = max(_scale(residual), least)
                weights = robust_weights(residual, _LOSS * scale)
        return _Found(coefficients, scale, share, tuple(one for one in terms if one.follows))

    @property
    def _rate(self) -> float:
        """Compared samples per second."""
        return self.motion.rate_hz / self.motion.step

    def sound(self, solution: Solution) -> Solution:
        """The fit that comes closest with every known constant within its tolerance.

        What is not known beforehand is as suits that best.
        """
        prior, given = solution.prior, solution.coefficients
        widths = np.divide(2.0, prior, out=np.full(prior.size, np.inf), where=prior > 0.0)
        if np.all(np.abs(given) <= widths):
            return solution
        columns, weights = self.columns(solution.terms), np.sqrt(solution.weights)
        short = np.linalg.qr((columns * weights[:, None])[self.fitted], mode="r")
        low = np.maximum([value for one in solution.terms for value in one.low], -widths)
        size = np.linalg.norm(short, axis=0) + 1e-300
        aim = short @ given  # so far the closest: what is added to it counts
        made = lsq_linear(short / size, aim, (low * size, widths * size), method="bvls").x / size
        left = self.target - columns @ made
        return replace(solution, coefficients=made, residual=left)

    @property
    def _noise(self) -> tuple[float, float]:
        """Noise of the acceleration, and inertia by which the target holds it."""
        return self.blur.noise, self.model.inertia or 0.0

    def blurred(self, terms: Sequence[Term]) -> FloatArray:
        """Share of the acceleration in each column, float64[k]."""
        made = [[one.inertia, *[0.0] * (one.columns.shape[0] - 1)] for one in terms]
        return np.array([value for row in made for value in row])

    def costs(self, solution: Solution, scale: float, rows: BoolArray) -> FloatArray:
        """Robust squared residual of each stretch among `rows`: mean over its samples."""
        loss = robust_squares(solution.residual, _LOSS * scale)
        return self.by_stretch(loss, rows)

    def by_stretch(self, values: FloatArray, rows: BoolArray) -> FloatArray:
        """Means over the stretches that have at least some of `rows`, usable ones: from 0 on."""
        numbers = self.stretch[rows]
        count = np.bincount(numbers)
        seen = count > 0
        means = np.bincount(numbers, weights=values[rows])[seen] / count[seen]
        count = count[seen]
        kept: FloatArray = means[count >= max(3, 0.2 * count.max(initial=0))]
        return kept

    def cross_validated(self, fit: Solution, scale: float) -> FloatArray:
        """Costs of the fitted stretches, each from a fit that left out its fold.

        fit: to all of them, from whose weights those fits need one step.
        """
        terms = fit.terms
        fitted = self.fitted
        residual = self.target.copy()
        for number in range(self.FOLDS):
            out = fitted & (self.fold == number)
            rest = fitted & ~out
            if not out.any():
                continue
            if rest.sum() < 4 * sum(one.size for one in terms) + 8:
                return self.by_stretch(np.full(residual.size, np.inf), fitted)
            solution = self.fit(terms, rest, 1, fit.prior, fit)
            residual[out] = solution.residual[out]
        loss = robust_squares(residual, _LOSS * scale)
        return self.by_stretch(loss, fitted)

    def power(self, solution: Solution, rows: BoolArray) -> FloatArray:
        """Mean products of the columns of its terms, float64[k, k], as robust as the fit."""
        columns, weights = self.columns(solution.terms)[rows], solution.weights[rows]
        made: FloatArray = (columns * weights[:, None]).T @ columns / weights.sum()
        return made


def beside(values: FloatArray, columns: FloatArray) -> FloatArray:
    """What columns float64[m, k] cannot give of values, float64[m] or float64[m, j]."""
    if not columns.size:
        return values
    left: FloatArray = values - columns @ np.linalg.lstsq(columns, values, rcond=None)[0]
    return left


def stretch_length(duration_s: float, moving_s: float | None = None) -> float:
    """Length of a stretch: 0.5 s, longer in long recordings, shorter where there are too few.

    moving_s: of the duration, time with motion; all of it unless given.
    """
    longest = max(STRETCH_S, duration_s / MOST_STRETCHES)
    told_s = duration_s if moving_s is None else min(moving_s, duration_s)
    return max(min(longest, told_s / (4 * HELD_OUT_EVERY)), 1e-6)


def _scale(residual: FloatArray) -> float:
    """Robust standard deviation about zero."""
    if residual.size == 0:
        return 0.0
    return max(typical_rms(residual), 1e-3 * _rms(residual))


def _rms(values: FloatArray) -> float:
    return math.sqrt(float(values @ values) / values.size)
