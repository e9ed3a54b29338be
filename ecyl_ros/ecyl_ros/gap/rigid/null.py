"""What every set of effects is fitted beside: what the file leaves out, what it is unsure of.

A constant is no better known than its tolerance, and is fitted at the price of a pull on it; what
the file leaves out is free. Alone this is the null: the best that the data sheet allows.
"""

from __future__ import annotations

import copy
from collections.abc import Collection, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ...arrays import BoolArray, FloatArray
from ...drive.rigid.machine import KEYS
from ...effects import actuation_delay
from ...effects.apart import apart
from ...effects.catalogue import RIGID, rigid_forms
from ...effects.term import Term
from ..compete.strain import STRAINED, UNSEEN
from ..inverse import inverse_of
from .balance import ROUNDS, Balance
from .mode import MODE, largest, mode
from .solution import Solution
from .terms import Catalogue

_GAIN = "actuation.gain"
_COUNTED = 2  # times that tolerances follow a gain which is free
_LEAST_RATIO = 0.05  # of the nominal one, that tolerances are counted by
_STEP = 0.5  # samples that a lag may be off by, once that of the sampling is taken out
_NEARLY = 0.8  # of what letting the most strained constant go would save


class Uncertain(NamedTuple):
    """A constant as a term; width: its tolerance, in what the coefficient counts."""

    term: Term
    width: float


class Null:
    """See the module.

    Attributes:
        balance, catalogue: of one recording. unknown: terms of what the file leaves out.
        uncertain: its constants, how far a recording lags, and what lies beyond its band.
        held: effects that stand for constants which keep to their tolerance.
        fits: made so far.
    """

    def __init__(self, balance: Balance, catalogue: Catalogue, held: Collection[str] = ()) -> None:
        self.balance, self.catalogue = balance, catalogue
        self.unknown = catalogue.unknown()
        self.uncertain = self._uncertain()
        self.held: frozenset[str] = frozenset()
        self.fits = 0
        if held:
            self.hold(held)

    def holding(self, effects: Collection[str]) -> Null:
        """The same, and the constants that these effects stand for keep to their tolerance."""
        other = copy.copy(self)
        other.hold(effects)
        return other

    def hold(self, effects: Collection[str]) -> None:
        """See `holding`; an effect that stands for no constant changes nothing."""
        self.held |= {
            one.term.effect
            for one in self.uncertain
            if one.term.effect in effects and one not in self._lag
        }
        self.uncertain = [
            one._replace(term=_within(one)) if one.term.effect in self.held else one
            for one in self.uncertain
        ]

    def with_own(self, effect: str) -> Null:
        """The same with values of its own for each recording of the constants an effect tells."""
        other, parts = copy.copy(self), self.catalogue.motion.parts
        other.uncertain = [
            one._replace(term=apart(one.term, parts)) if one.term.effect == effect else one
            for one in self.uncertain
        ]
        return other

    def common(self) -> Null:
        """The same with one value of each constant for all recordings."""
        other = copy.copy(self)
        other.uncertain = [one._replace(term=one.term.common or one.term) for one in self.uncertain]
        return other

    @property
    def sheet(self) -> bool:
        """Whether the file states constants that are uncertain."""
        return any(any(RIGID[one.term.effect].constant) for one in self.uncertain)

    def fit(
        self, terms: Sequence[Term], rows: BoolArray | None = None, rounds: int = ROUNDS
    ) -> Solution:
        """A set of effects beside the null; rows: bool[m], the fitted ones unless given."""
        self.fits += 1
        every, prior = self._beside(terms)
        made = self.balance.fit(every, rows, rounds, prior)
        for _ in range(_COUNTED if any(one.key == "gain" for one in terms) else 0):
            by_gain = prior / self._per_nominal(made)
            made = self.balance.fit(every, rows, rounds, by_gain)
        return made

    def cross_validated(self, terms: Sequence[Term], scale: float) -> tuple[FloatArray, Solution]:
        """See `Balance.cross_validated`; raised by the price of the fit to all folds, and that."""
        self.fits += self.balance.FOLDS
        fit = self.fit(terms, rounds=3)
        costs = self.balance.cross_validated(fit, scale)
        return costs * fit.dearer, fit

    def strained(self, solution: Solution) -> tuple[str, ...]:
        """Effects that stand for the constants that lie furthest beyond their sheet.

        None where all may be sound. By what it would save to let each go, as `strain` has it; here
        it is exact. What saves nearly as much as the first may be what is exchanged for it.
        """
        columns = self.balance.columns(solution.terms)[self.balance.fitted]
        weights = solution.weights[self.balance.fitted]
        gram = (columns * weights[:, None]).T @ columns / max(solution.share, 1e-300)
        inverse = inverse_of(gram + np.diag(solution.prior**2))
        found, at = dict[str, float](), 0
        for term in solution.terms:
            price = (solution.prior[at] * solution.coefficients[at]) ** 2
            seen = 1.0 - solution.prior[at] ** 2 * inverse[at, at]
            free = price > 0.0 and term.effect not in self.held
            if free and seen > UNSEEN and price / seen > STRAINED:
                found[term.effect] = price / seen
            at += term.columns.shape[0]
        least = _NEARLY * max(found.values(), default=0.0)
        return tuple(name for name, saved in found.items() if saved >= least)

    def nominal(self, rows: BoolArray | None = None) -> Solution:
        """The file's values as they stand, in step with the effort as far as sampling goes."""
        self.fits += 1
        every = [*self.unknown, *(one.term for one in self._lag)]
        prior = [0.0] * len(self.unknown) + [2.0 / one.width for one in self._lag]
        return self.balance.sound(self.balance.fit(every, rows, prior=np.array(prior)))

    @property
    def _lag(self) -> list[Uncertain]:
        return [one for one in self.uncertain if not any(RIGID[one.term.effect].constant)]

    def _beside(self, terms: Sequence[Term]) -> tuple[list[Term], FloatArray]:
        """With every constant that no effect of the set stands for; and what they are known to."""
        taken = {name for one in terms for name in (one.effect, *one.refines)}
        # A delay takes the place of the lag, and of nothing else that is late.
        beside = [
            one for one in self.uncertain if one.term.key == MODE or one.term.effect not in taken
        ]
        every = [*self.unknown, *terms, *(one.term for one in beside)]
        known = [2.0 / one.width for one in beside for _ in range(one.term.columns.shape[0])]
        free = sum(one.columns.shape[0] for one in every) - len(known)
        return every, np.array([*[0.0] * free, *known])

    def _uncertain(self) -> list[Uncertain]:
        catalogue = self.catalogue
        machine, linear = catalogue.machine, catalogue.machine.linear
        per_own = self._per_own()
        found = []
        for key, width in machine.half_widths().items():
            if width <= 0.0 or any(key in RIGID[one.name].constant for one in machine.effects):
                continue
            # Of a measured torque nothing but another torque tells how it is counted.
            of_sensor = key == _GAIN and machine.actuation in ("force", "torque")
            if of_sensor and not catalogue.motion.injected.any():
                continue
            # The gain's coefficient is a share; others count effort as it was recorded.
            scale = 1.0 / float(getattr(machine, KEYS[key].field)) if key == _GAIN else per_own
            found += [
                Uncertain(catalogue.own(form.term(catalogue.along)), scale * width)
                for form in rigid_forms(linear).values()
                if form.constant[not linear] == key
            ]
        if machine.actuation == "loop":  # told from the motion itself: no logger comes between
            return found
        motion, lag_s = catalogue.motion, self.balance.lag_s
        late = actuation_delay.lag(catalogue.along, lag_s)
        found.append(Uncertain(late, _STEP / motion.rate_hz))
        beyond = mode(motion, lag_s)
        return found if beyond is None else [*found, Uncertain(beyond, largest(motion))]

    def _per_nominal(self, solution: Solution) -> FloatArray:
        """By what the tolerance of each coefficient grows with the gain that was found, float64[k].

        A tolerance in N or N m is another one in the effort as it was recorded.
        """
        grown = self.gained(solution)
        parts = [[grown if one.of_effort else 1.0] * one.columns.shape[0] for one in solution.terms]
        return np.concatenate(parts)

    def gained(self, solution: Solution) -> float:
        """Effort as recorded per N or N m by the gain that was found, over that of the file."""
        model = self.catalogue.model
        return max(solution.ratio(model) / model.ratio, _LEAST_RATIO) if model.ratio > 0.0 else 1.0

    def _per_own(self) -> float:
        """Effort as recorded per N or N m."""
        along = self.catalogue.along
        if along.known_gain:
            return along.model.counted
        plain = self.balance.fit(self.unknown)
        gains = [float(plain.of(one)[0]) for one in self.unknown if one.key == "gain"]
        return gains[0] if gains else 0.0


def _within(one: Uncertain) -> Term:
    """Its term, which may not leave the tolerance."""
    count = one.term.columns.shape[0]
    low = tuple(max(least, -one.width) for least in one.term.low)
    return replace(one.term, low=low, high=(one.width,) * count)
