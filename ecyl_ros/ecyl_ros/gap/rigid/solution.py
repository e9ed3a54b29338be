"""A fit of a set of terms to the balance of efforts, and what it leaves."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ...arrays import BoolArray, FloatArray
from ...drive.rigid.model import Model
from ...effects.actuation_delay import LAG
from ...effects.term import Term
from .mode import MODE

# Of the structure that is left, along one effect: what the set could not take is shaped otherwise.
_BENDS = 0.5


@dataclass(frozen=True, eq=False)
class Solution:
    """A fit of a set of terms.

    Attributes:
        terms: in the order of the coefficients.
        coefficients: float64[k]. residual: float64[m], all compared samples. weights: float64[m]
            of the robust loss. scale: robust standard deviation of the residual on the fitted rows.
        prior: float64[k], one over the standard deviation that a coefficient is known with about
            0 beforehand; 0 where nothing is. share: squared residuals that the square of a
            coefficient over that counts as.
        evidence: independent pieces that the recording holds.
    """

    terms: tuple[Term, ...]
    coefficients: FloatArray
    residual: FloatArray
    weights: FloatArray
    scale: float
    prior: FloatArray
    share: float
    evidence: float

    def of(self, term: Term) -> FloatArray:
        """The coefficients of one term."""
        at = 0
        for one in self.terms:
            size = one.columns.shape[0]
            if one is term:
                return self.coefficients[at : at + size]
            at += size
        raise KeyError(term.key)

    def known(self, term: Term) -> bool:
        """Whether a term was fitted as a constant that is known beforehand."""
        at = 0
        for one in self.terms:
            if one is term:
                return bool(self.prior[at] > 0.0)
            at += one.columns.shape[0]
        raise KeyError(term.key)

    def inertia(self, model: Model) -> float:
        """By which the effort follows the acceleration, in the unit of the effort: the file's and
        what the terms add."""
        added = sum(one.inertia * float(self.of(one)[0]) for one in self.terms if one.inertia)
        return (model.inertia or 0.0) + added

    def ratio(self, model: Model) -> float:
        """Effort as recorded per N or N m: the file's and what the terms add."""
        return model.ratio + sum(float(self.of(one)[0]) for one in self.terms if one.key == "gain")

    def rms(self, rows: BoolArray) -> float:
        """Of what it leaves on `rows`, bool[m]."""
        return float(np.sqrt(np.mean(self.residual[rows] ** 2)))

    def bends(self, rows: BoolArray, floor: float) -> float:
        """RMS of what is left on `rows` beyond a floor that may be along any one effect."""
        return _BENDS * math.sqrt(max(self.rms(rows) ** 2 - floor**2, 0.0))

    @property
    def beyond(self) -> set[str]:
        """Effects that stand for known constants which lie outside their tolerance."""
        effects = [one.effect for one in self.terms for _ in range(one.columns.shape[0])]
        off = np.abs(self.prior * self.coefficients) > 2.0
        return {name for name, far in zip(effects, off, strict=True) if far}

    @property
    def price(self) -> float:
        """Of the pulls on the sheet, see `gap.sheet`."""
        return float(np.sum((self.prior * self.coefficients) ** 2))

    @property
    def dearer(self) -> float:
        """What a mean square counts by that price, over its own value."""
        return math.exp(min(self.price / self.evidence, 100.0))

    def priced(self, rows: BoolArray) -> float:
        """RMS of what it leaves on `rows`, bool[m], raised by that price."""
        return self.rms(rows) * math.sqrt(self.dearer)

    def explained(self, nominal: FloatArray) -> FloatArray:
        """Effort explained on the grid of the motion: nominal plus the terms of the machine."""
        made = nominal.copy()
        for one in self.terms:
            if one.key not in (LAG, MODE):
                made += self.of(one) @ one.columns
        return made

    def carried(self, nominal: FloatArray) -> FloatArray:
        """Load carried on the grid of the motion: nominal plus what the terms add."""
        made = nominal.copy()
        for one in self.terms:
            if one.carried is not None:
                made += self.of(one) @ one.carried
        return made

    @property
    def free(self) -> tuple[Term, ...]:
        """Terms that nothing is known of beforehand."""
        return tuple(one for one in self.terms if not self.known(one))

    @property
    def effects(self) -> tuple[str, ...]:
        """Names of these, each once."""
        return tuple(dict.fromkeys(one.effect for one in self.free))
