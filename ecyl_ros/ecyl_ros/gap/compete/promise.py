"""What a start may come to, told from its response before it is fitted.

Responses are added up with free sizes on every fifth sample, beside what the base could still do by
its own parameters and by the sheet, which is held back by its price.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from ...arrays import FloatArray
from ...effects.catalogue import CATALOGUE
from ..fit.fit import Fit, Fitter, Values
from ..fit.robust import robust_mean_square
from .joint import resized

_STRIDE = 5  # responses are added up on every fifth sample
_LARGEST = 5.0  # times a start that its response may suggest
_ALIKE = 1.01  # times the least score: starts of one effect that promise the same
_SHOWN = 2  # further sets that go on, for what their replays have shown


@dataclass(frozen=True, eq=False)
class Promise:
    """A start upon `base`: what it may leave (`score`) at `size` times its size."""

    score: float
    size: float
    fit: Fit
    base: Fit


def best_of_each(promises: Iterable[Promise]) -> list[Promise]:
    """The best start of each set of effects, most promising first.

    Of starts that promise alike, the one whose replay alone leaves least: where responses do not
    add up, all of them promise what their base leaves.
    """
    each: dict[frozenset[str], list[Promise]] = {}
    for one in promises:
        each.setdefault(frozenset(one.fit.names), []).append(one)
    best = []
    for starts in each.values():
        least = min(one.score for one in starts)
        alike = [one for one in starts if one.score <= _ALIKE * least]
        best.append(min(alike, key=lambda one: one.fit.fitted))
    return sorted(best, key=lambda one: one.score)


def foremost(promises: Sequence[Promise], most: int) -> list[Promise]:
    """The first of promises, and those beyond whose replay alone leaves least, if that is less than
    what their base leaves: it holds where responses do not add up.

    promises: of one start for each set, most promising first. most: so many go by their promise.
    """
    shown = [one for one in promises[most:] if one.fit.fitted < one.base.fitted]
    shown.sort(key=lambda one: one.fit.fitted)
    return [*promises[:most], *shown[:_SHOWN]]


class Promises:
    """Weighs starts by what is left of `null`, the sheet alone."""

    def __init__(self, fitter: Fitter, null: Fit) -> None:
        self.fitter, self.null = fitter, null
        thin = null.gap[:, np.flatnonzero(fitter.rows)[::_STRIDE]]
        scale = 3.0 + 3.0 * float(np.median(np.abs(thin)))
        self._weights = 1.0 / np.sqrt(1.0 + (thin / scale) ** 2)
        # What a pull weighs beside the thinned rows, as the sheet is weighed against a cost.
        level = float(np.mean((thin * self._weights) ** 2))
        self._pull_weight = 2.0 * math.sqrt(level * thin.size / fitter.sheet.evidence)
        self._last: Upon | None = None

    def thin(self, fit: Fit) -> FloatArray:
        """What a fit leaves on the thinned rows, and below it its pulls, weighed by their price."""
        rows = np.flatnonzero(self.fitter.rows)[::_STRIDE]
        gap = (fit.gap[:, rows] * self._weights).ravel()
        return np.concatenate([gap, self._pull_weight * fit.pulls])

    def cost(self, rest: FloatArray) -> float:
        """The cost of what is left, in the form of `thin`."""
        size = rest.size - len(self.fitter.sheet)
        pulls = rest[size:] / self._pull_weight
        return self.fitter.sheet.priced(robust_mean_square(rest[:size]), pulls)

    def upon(self, base: Fit) -> Upon:
        """What responses are weighed against upon `base`; worked out once for one base in a row."""
        if self._last is None or self._last.base is not base:
            self._last = Upon(self, base)
        return self._last

    def best(self, base: Fit, started: Sequence[Fit]) -> list[Promise]:
        """The best start of each set upon `base`, most promising first."""
        upon = self.upon(base)
        return best_of_each(upon.promise(one) for one in started)

    def sized(self, promise: Promise) -> Fit:
        """The start, or the same in the size that its response suggests, if that is better."""
        fit = promise.fit
        (name,) = set(fit.names) - set(promise.base.names)
        if promise.size <= 0.0 or 0.8 < promise.size < 1.25:
            return fit
        drive = self.fitter.replay.drive
        values = CATALOGUE[name].scaled(fit.values[name], promise.size, drive)
        other = self.fitter.evaluate({**fit.values, name: values}, fit.pulls)
        return min((fit, other), key=lambda one: one.fitted)

    def pairs(self, library: Sequence[Fit], most: int) -> list[tuple[float, Values]]:
        """Sets of two whose responses, added up with free sizes, leave least; and how much.

        library: starts and fits of single effects upon the sheet alone. most: so many sets.
        """
        target, basis = self.thin(self.null), self.basis(self.null)
        responses = np.array([target - self.thin(one) for one in library])
        responses -= (responses @ basis.T) @ basis
        target = target - (basis @ target) @ basis
        gram, along = responses @ responses.T, responses @ target
        drive = self.fitter.replay.drive
        found: dict[frozenset[str], tuple[float, Values]] = {}
        for i, first in enumerate(library):
            for j in range(i):
                second = library[j]
                if first.names == second.names:
                    continue
                determinant = gram[i, i] * gram[j, j] - gram[i, j] ** 2
                if not determinant > 1e-6 * gram[i, i] * gram[j, j]:
                    continue
                a = (along[i] * gram[j, j] - along[j] * gram[i, j]) / determinant
                b = (along[j] * gram[i, i] - along[i] * gram[i, j]) / determinant
                if not (0.03 < a < 3.0 and 0.03 < b < 3.0):
                    continue
                left = float(target @ target - a * along[i] - b * along[j]) / target.size
                key = frozenset((*first.names, *second.names))
                if key not in found or left < found[key][0]:
                    found[key] = (
                        left,
                        {**resized(first, a, drive), **resized(second, b, drive)},
                    )
        return sorted(found.values(), key=lambda pair: pair[0])[:most]

    def basis(self, fit: Fit) -> FloatArray:
        """Orthonormal directions in which the fit can still move, each in the form of `thin`.

        The sheet's are held back by their price, which stands at the end of each.
        """
        size = self.thin(fit).size
        if fit.jacobian is None:
            return np.zeros((0, size))
        count, first = len(fit.jacobian), len(fit.coordinates)
        slopes = fit.jacobian.reshape(count, fit.gap.shape[0], -1)[:, :, ::_STRIDE]
        priced = np.zeros((count, len(self.fitter.sheet)))
        priced[range(first, count), list(fit.pulled)] = self._pull_weight
        rows = np.concatenate([(slopes * self._weights).reshape(count, -1), priced], axis=1)
        basis: FloatArray = np.ascontiguousarray(np.linalg.qr(rows.T)[0].T)
        return basis


class Upon:
    """What `base` leaves, less what it could still do by its own parameters and by the sheet."""

    def __init__(self, promises: Promises, base: Fit) -> None:
        self.base, self._promises = base, promises
        self._basis = promises.basis(base)
        self._target = promises.thin(base)
        self.free = self._without(self._target)

    def _without(self, values: FloatArray) -> FloatArray:
        return values - (self._basis @ values) @ self._basis

    def response(self, fit: Fit) -> FloatArray:
        """Of a start, less what the base could do as well; `free` is what it is held against."""
        return self._without(self._target - self._promises.thin(fit))

    def promise(self, fit: Fit) -> Promise:
        """What a start would leave, were it free in size (and linear)."""
        response = self.response(fit)
        power = float(response @ response)
        size = float(response @ self.free) / power if power > 0.0 else 0.0
        size = min(max(size, 0.0), _LARGEST)
        left = self._promises.cost(self.free - size * response)
        return Promise(min(fit.fitted, left), size, fit, self.base)
