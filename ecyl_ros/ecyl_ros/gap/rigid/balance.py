"""The balance of efforts as a robust regression: columns in, coefficients and residual out."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import lsq_linear
from scipy.stats import t as student

from ...drive.rigid.model import Model
from ...effects.term import Interval, Parameters, Term
from ..diagnosis import BoolArray, FloatArray
from ..fit.robust import robust_squares, robust_weights
from ..sheet import EVIDENCE_PER_S
from ..split import STRETCH_S
from .motion import Motion
from .normal import MOST_BLUR, freed, solve
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
UNMODELLED = 0.01  # share of the effort that no model of one inertia explains
_ALONG_A_WAVE = 0.5  # of that; models err smoothly, and in other directions by all of it
_NOTHING = 1e-12  # of the variance that white noise gives
_REMEMBERED = 512  # fits that are kept, of some thousand
_FORM = 1e-3  # half width, as a share of the value, that no interval falls below


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
        lag_s: see below.
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
            _LEAST_MOVING_S * motion.rate_hz / motion.step,
            _LEAST_MOVING * max(motion.usable[rows].sum(), 1),
        )
        self.rests = bool(moving.sum() >= enough)
        self.usable: BoolArray = moving if self.rests else motion.usable[rows]
        part = self.time_s[self.usable]
        begin, end = (float(part[0]), float(part[-1])) if part.size else (0.0, 1.0)
        self.stretch_s = stretch_length(end - begin)
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
    ) -> Solution:
        """Robust least squares (Cauchy loss by reweighting) within the terms' bounds.

        prior: see `Solution`; the price of a data sheet, (2 pull)^2, against the evidence of the
        recording (see `gap.sheet`).
        """
        rows = self.fitted if rows is None else rows
        parts = self._parts(terms)
        prior = np.zeros(sum(map(len, parts))) if prior is None else prior
        # Competing sets come up again and again.
        of = tuple(
            (one.key, id(one) if one.follows else 0, one.low, one.high, one.inertia)
            for one in terms
        )
        asked = (of, rows.tobytes(), rounds, prior.tobytes())
        found = self._fits.get(asked)
        if found is None:
            if len(self._fits) == _REMEMBERED:
                del self._fits[next(iter(self._fits))]
            found = self._fits[asked] = self._found(terms, parts, rows, rounds, prior)
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
    ) -> _Found:
        """Coefficients by some rows alone; parts: columns of each term, float64[k, m]."""
        target, weights = self.target[rows], np.ones(int(rows.sum()))
        # What is less than the effort's rounding is no scale for anything.
        least = max(_ROUNDING * float(np.sqrt(np.mean(self.effort**2))), 1e-300)
        scale, share = max(_scale(target), least), 0.0
        coefficients = np.zeros(prior.size)
        if terms:
            low = np.array([value for one in terms for value in one.low])
            high = [value for one in terms for value in one.high or [math.inf] * len(one.low)]
            bounds, blurred = (low, np.array(high)), self._blurred(terms)
            columns = np.concatenate([one[:, rows] for one in parts])
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

    def _blurred(self, terms: Sequence[Term]) -> FloatArray:
        """Share of the acceleration in each column, float64[k]."""
        made = [[one.inertia, *[0.0] * (one.columns.shape[0] - 1)] for one in terms]
        return np.array([value for row in made for value in row])

    def costs(self, solution: Solution, scale: float, rows: BoolArray) -> FloatArray:
        """Robust squared residual of each stretch among `rows`: mean over its samples."""
        loss = robust_squares(solution.residual, _LOSS * scale)
        return self.by_stretch(loss, rows)

    def by_stretch(self, values: FloatArray, rows: BoolArray) -> FloatArray:
        """Means over the stretches that have at least some of `rows`."""
        labels = np.unique(self.stretch[rows], return_inverse=True)[1]
        count = np.bincount(labels)
        means = np.bincount(labels, weights=values[rows]) / np.maximum(count, 1)
        kept: FloatArray = means[count >= max(3, 0.2 * count.max(initial=0))]
        return kept

    def cross_validated(
        self, terms: Sequence[Term], scale: float, prior: FloatArray | None = None
    ) -> FloatArray:
        """Costs of the fitted stretches, each from a fit that left out its fold."""
        fitted = self.fitted
        residual = self.target.copy()
        for number in range(self.FOLDS):
            out = fitted & (self.fold == number)
            rest = fitted & ~out
            if not out.any():
                continue
            if rest.sum() < 4 * sum(one.size for one in terms) + 8:
                return self.by_stretch(np.full(residual.size, np.inf), fitted)
            solution = self.fit(terms, rest, 3, prior)
            residual[out] = solution.residual[out]
        loss = robust_squares(residual, _LOSS * scale)
        return self.by_stretch(loss, fitted)

    def covariance(self, solution: Solution, rows: BoolArray) -> tuple[FloatArray, int]:
        """Of the coefficients fitted on `rows`, and the number of stretches that it rests on.

        The sandwich estimator over stretches: what is left may be correlated within one as it
        likes. Never less than white noise of the residual's size would give.
        """
        columns = self.columns(solution.terms)[rows]
        weights = solution.weights[rows]
        residual = solution.residual[rows]
        inverse = self._inverse(solution, columns, weights)
        labels = np.unique(self.stretch[rows], return_inverse=True)[1]
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

    def _inverse(self, solution: Solution, columns: FloatArray, weights: FloatArray) -> FloatArray:
        """Of the normal equations, float64[k, k]; columns, weights: float64[m, ...] of its rows."""
        ridge = np.diag(solution.prior**2 * solution.share)
        gram = (columns * weights[:, None]).T @ columns + ridge
        blurred = self._blurred(solution.terms)
        size = np.sqrt(np.diag(gram))
        size[size == 0.0] = 1.0
        gram -= freed(gram, blurred, float(weights.sum()) * self.blur.noise**2)
        scaled = gram / np.outer(size, size)
        made: FloatArray = np.linalg.pinv(scaled, hermitian=True) / np.outer(size, size)
        return made

    def unsure(self, solution: Solution, rows: BoolArray) -> FloatArray:
        """How far coefficients may be off by noise of the position, float64[k], signed.

        By the steps of the encoder: noise in a column makes its coefficient too small; how much of
        the steps is noise depends on how the motion meets them. By noise that went round the loop:
        a delay cancels some of it, and so comes out too long.
        """
        blurred = self._blurred(solution.terms)
        columns, weights = self.columns(solution.terms)[rows], solution.weights[rows]
        inverse = self._inverse(solution, columns, weights)
        more = max(self.blur.counted**2 - self.blur.noise**2, 0.0) * float(weights.sum())
        told = float(blurred @ inverse @ blurred)
        more = min(more, MOST_BLUR / told if told > 0.0 else 0.0)
        made: FloatArray = more * solution.inertia(self.model) * (inverse @ blurred)
        looped = [self.blur.looped(one.sought) if one.sought else 0.0 for one in solution.terms]
        if any(looped):
            shared = np.repeat(looped, [one.columns.shape[0] for one in solution.terms])
            made = made - float(weights.sum()) * (inverse @ shared)
        return made

    def unmodelled(self, *, wave: bool) -> float:
        """RMS of what no model explains, along one effect; wave: whether that is a sine."""
        share = UNMODELLED * (_ALONG_A_WAVE if wave else 1.0)
        return share * float(np.std(self.effort[self.usable]))

    def _modelled(self, solution: Solution, rows: BoolArray, left: float) -> FloatArray:
        """Squares and products of how far coefficients may be off by what no model explains, and by
        what is `left`, float64[k, k]."""
        size = [
            math.hypot(self.unmodelled(wave=one.rate != 0.0), left)
            for one in solution.terms
            for _ in range(one.columns.shape[0])
        ]
        made: FloatArray = np.outer(size, size) * self._swayed(solution, rows)
        return made

    def _swayed(self, solution: Solution, rows: BoolArray) -> FloatArray:
        """The same, float64[k, k], for an effort of RMS 1 along each coefficient."""
        columns, weights = self.columns(solution.terms)[rows], solution.weights[rows]
        inverse = self._inverse(solution, columns, weights)
        told = inverse @ ((columns * weights[:, None]).T @ columns) @ inverse
        made: FloatArray = told * weights.sum()
        return made

    def power(self, solution: Solution, rows: BoolArray) -> FloatArray:
        """Mean products of the columns of its terms, float64[k, k], as robust as the fit."""
        columns, weights = self.columns(solution.terms)[rows], solution.weights[rows]
        made: FloatArray = (columns * weights[:, None]).T @ columns / weights.sum()
        return made

    def half_width(
        self, solution: Solution, rows: BoolArray, combined: FloatArray, left: float = 0.0
    ) -> float:
        """95 % half width of a combination of the coefficients; combined: weight of each,
        float64[k]. left: as in `intervals`."""
        covariance, count = self.covariance(solution, rows)
        quantile = _quantile(count, solution)
        parts = quantile**2 * covariance + self._modelled(solution, rows, left)
        return math.sqrt(max(float(combined @ parts @ combined), 0.0))

    def intervals(
        self, solution: Solution, rows: BoolArray, left: float = 0.0
    ) -> dict[str, list[Interval]]:
        """95 % intervals of the parameters of each term, by its key; by the delta method.

        left: RMS of the structure that is still left: a further effect of that size would bend the
        values of those that were found.
        """
        covariance, count = self.covariance(solution, rows)
        unsure = self.unsure(solution, rows)
        modelled = _roots(self._modelled(solution, rows, left))
        own = self.model.counted == 1.0
        gain = next((at for at, one in enumerate(_keys(solution.terms)) if one == "gain"), None)
        quantile = _quantile(count, solution)
        found: dict[str, list[Interval]] = {}
        at = 0
        for term in solution.terms:
            size = term.columns.shape[0]
            rows_of = [*range(at, at + size)]
            scaled = own and term.of_effort
            if scaled and gain is not None:
                rows_of.append(gain)
            values = solution.coefficients[rows_of]
            part = covariance[np.ix_(rows_of, rows_of)]
            base = self._told(term, values, scaled)
            made: list[Interval] = []
            slopes = np.zeros((len(base), len(rows_of)))
            for index in range(len(rows_of)):
                step = 1e-3 * math.sqrt(max(part[index, index], 1e-300))
                moved = values.copy()
                moved[index] += step
                for number, (_, _, value) in enumerate(self._told(term, moved, scaled)):
                    slopes[number, index] = (value - base[number][2]) / step
            for number, (name, unit, value) in enumerate(base):
                off = float(slopes[number] @ unsure[rows_of])
                spread = math.sqrt(max(float(slopes[number] @ part @ slopes[number]), 0.0))
                form = float(np.linalg.norm(slopes[number] * modelled[rows_of]))
                half = math.hypot(quantile * spread, form, _FORM * abs(value))
                if name in term.fixed:
                    half = quantile * _searched(term, name, value, base[0][2], part[:size, :size])
                if number == 0:
                    half = math.hypot(half, term.unsure)
                low, high = value - half + min(off, 0.0), value + half + max(off, 0.0)
                made.append(Interval(name, unit, value, low, high))
            found[term.key] = made
            at += size
        return found

    def _told(self, term: Term, values: FloatArray, scaled: bool) -> Parameters:
        """Parameters of coefficients, float64[k]; one more is that of the gain beside them.

        scaled: counted by the true gain, not as the effort was recorded.
        """
        size = term.columns.shape[0]
        gain = self.model.ratio + float(values[size:].sum()) if scaled else 1.0
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


def _searched(
    term: Term, name: str, value: float, amplitude: float, covariance: FloatArray
) -> float:
    """Standard deviation of a parameter that was searched: the rate of a sine, or one in steps.

    sigma_f = sqrt(3) / pi x sigma_A / (A T) for a sine seen over T (Rife, Boorstyn, 1974). A period
    follows from its rate.
    """
    if name in term.steps:
        return term.steps[name]
    if term.extent <= 0.0 or amplitude <= 0.0:
        return 0.0
    ratio = math.sqrt(max(float(np.trace(covariance)) / 2.0, 0.0)) / amplitude
    spread = math.sqrt(3.0) / math.pi * ratio / term.extent
    return spread * value**2 if name == "period_m" else spread


def beside(values: FloatArray, columns: FloatArray) -> FloatArray:
    """What columns float64[m, k] cannot give of values, float64[m] or float64[m, j]."""
    if not columns.size:
        return values
    left: FloatArray = values - columns @ np.linalg.lstsq(columns, values, rcond=None)[0]
    return left


def stretch_length(duration_s: float) -> float:
    """Length of a stretch: 0.5 s, longer in long recordings, shorter where there are too few."""
    longest = max(STRETCH_S, duration_s / MOST_STRETCHES)
    return max(min(longest, duration_s / (4 * HELD_OUT_EVERY)), 1e-6)


def _scale(residual: FloatArray) -> float:
    """Robust standard deviation about zero."""
    if residual.size == 0:
        return 0.0
    middle = 1.4826 * float(np.median(np.abs(residual)))
    return max(middle, 1e-3 * float(np.sqrt(np.mean(residual**2))))
