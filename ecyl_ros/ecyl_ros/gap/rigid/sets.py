"""Sets of terms on one balance: fitted, extended, and weighed on stretches that no fit saw."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ...arrays import FloatArray
from ...effects import constant_load
from ...effects.catalogue import RIGID
from ...effects.term import Left, Term
from ..compete.strain import STRAINED
from .expected import log_odds
from .floor import Pairs, pairs
from .null import Null
from .search import left_by
from .searched import slopes
from .solution import Solution
from .terms import bare_beside, free_means, one_mean

LEAST_GAIN = 0.12  # of the squared residual above the floor
SURE = 2.5  # standard errors over the stretches, fitted ones
HELD_SURE = 1.3  # the same on the held-out ones, which are fewer: two clear passes, not one
_AT_FLOOR = 0.5  # share of the squared residual that may be explained even at the floor
_WORST = 6.0  # times the median stretch: what one stretch counts at the most
_HURT = 4.0  # times that, where an effect is left out: it may hurt in few places
_WIDTHS = 2.0  # of a line, that another one is away
TIE = 1e-4  # of a cost: so near, two are one
_SAME = 5  # terms of one effect of several orders or frequencies


class Standing(NamedTuple):
    """Where a set stands.

    costs: cross-validated squared residual of each stretch, none above `cap`. surplus: what of
    their mean stands above the floor. scale: of the robust loss. price: of its pulls on the sheet.
    strained: effects that stand for what lies beyond it.
    """

    costs: FloatArray
    cap: float
    surplus: float
    scale: float
    price: float
    strained: tuple[str, ...]


class Gain(NamedTuple):
    """What one set leaves less than another.

    share: of the surplus. sureness: that over its standard error. saved: price of the sheet, by an
    effect that stands for a constant of it. known: log odds of the effect beforehand.
    """

    share: float
    sureness: float
    saved: float
    known: float = 0.0

    @property
    def earned(self) -> bool:
        """Whether it is a good part, and more than the stretches differ among themselves."""
        return self._relieved or (self.share >= LEAST_GAIN and self._surer(SURE))

    @property
    def kept(self) -> bool:
        """The same on fewer stretches, which have to say so a second time."""
        share = self.share >= 0.5 * LEAST_GAIN
        return self._relieved or (share and self._surer(HELD_SURE))

    @property
    def likely(self) -> bool:
        """Whether it is a good part, and more than its standard error."""
        return self._relieved or (self.share >= LEAST_GAIN and self.sureness >= 1.0)

    def _surer(self, least: float) -> bool:
        """Whether it is by `least` standard errors, or by what is known as well: z^2 / 2 nats."""
        return self.sureness > 0.0 and self.sureness**2 + 2.0 * self.known >= least**2

    @property
    def _relieved(self) -> bool:
        """Whether constants are back that would otherwise have to lie beyond their sheet."""
        return self.saved > STRAINED and self.share > 0.0


class Sets:
    """See the module.

    Attributes:
        null: what every set is fitted beside. balance, catalogue: its own. floor: standard
            deviation below which there is nothing to explain. barred: effects to do without.
    """

    def __init__(self, null: Null, floor: float, without: Collection[str]) -> None:
        self.null, self.balance, self.catalogue = null, null.balance, null.catalogue
        self.floor, self.barred = floor, set(without)

    @cached_property
    def _same(self) -> Pairs:
        """Instants in the same state of motion."""
        catalogue = self.catalogue
        return pairs(self.balance, not catalogue.machine.linear and catalogue.along.turns)

    def fit(self, terms: Sequence[Term]) -> Solution:
        """A set beside the null."""
        return self.null.fit(terms)

    def on_sheet(self, terms: Sequence[Term], out: str, beside: Solution) -> Solution:
        """A set beside the null on a sound sheet, without the effect `out`.

        A set that does as well with that effect's constant off the sheet has the effect still; with
        another off it, it has a further one. beside: of what may be off, for it is there as well.
        """
        allowed = {*self.null.strained(beside), *(one.effect for one in terms)} - {out}
        null = self.null.holding({out})
        self.null.fits += 1
        fit = null.fit(terms)
        while more := set(null.strained(fit)) - allowed:
            held, null = null.held, null.holding(more)
            if null.held == held:  # a lag: of the recording, not of the sheet
                break
            fit = null.fit(terms)
        return fit

    def left(self, current: Solution, chosen: Sequence[Term]) -> Left:
        """What a set leaves."""
        orders = [one.effect for one in chosen if one.rate and not one.over_time]
        enough = any(orders.count(name) >= _SAME for name in orders)
        return left_by(self.balance, self.catalogue.along, current, lambda: self._same, enough)

    def candidates(
        self, current: Solution, chosen: Sequence[Term], among: Collection[str] | None = None
    ) -> list[Term]:
        """Terms that a set may be extended by; among: effects, None for all.

        Of an effect that is tried in some places and acts but once, the best of them, tuned.
        """
        found, best = list[Term](), dict[str, tuple[float, Term]]()
        for one in self._candidates(current, chosen, among):
            if not one.reach or RIGID[one.effect].several:
                found.append(one)
                continue
            cost = self.cost(self.fit(self.extended(chosen, one)), current.scale)
            if one.effect not in best or cost < best[one.effect][0]:
                best[one.effect] = cost, one
        for _, one in best.values():
            more = self.extended(chosen, one)
            found.append(self.tuned(more, len(more) - 1))
        return found

    def _candidates(
        self, current: Solution, chosen: Sequence[Term], among: Collection[str] | None
    ) -> list[Term]:
        kinds = [one.effect for one in chosen]
        taken = {one.key for one in chosen}
        finer = {name for one in chosen for name in one.refines}
        every = self.catalogue.candidates(self.left(current, chosen), among)
        return [
            one
            for one in bare_beside(chosen, every)
            if one.effect not in self.barred
            and not self.barred.intersection(one.contained)  # which would bring it back in
            and kinds.count(one.effect) < (_SAME if RIGID[one.effect].several else 1)
            and one.key not in taken
            and one.effect not in finer
            and self.elsewhere(one, [other for other in chosen if other.effect == one.effect])
        ]

    def elsewhere(self, one: Term, found: Sequence[Term]) -> bool:
        """Whether a line is another one than those found: more than its width away from each.

        Two within one width are one line that changes.
        """
        along = np.ptp(self.balance.time_s) if one.over_time else 0.0
        along = along or float(np.ptp(self.catalogue.along.turn.angle)) / math.tau
        return all(abs(one.rate - other.rate) * along > _WIDTHS for other in found)

    def extended(self, chosen: Sequence[Term], added: Term) -> list[Term]:
        """A set with one more term, which may take the place of others."""
        kept = [one for one in chosen if one.effect not in added.refines]
        return one_mean([*(self.levelled(kept) if RIGID[added.effect].several else kept), added])

    def levelled(self, chosen: Sequence[Term]) -> list[Term]:
        """With a free mean: a sine over part of its period has one, which must not decide."""
        if free_means(chosen) or "constant_load" in self.barred:
            return list(chosen)
        return [*chosen, self.catalogue.own(constant_load.term(self.catalogue.along))]

    def standing(self, current: Solution, chosen: Sequence[Term]) -> Standing:
        """Of a set whose fit is `current`."""
        now, fit = self.null.cross_validated(chosen, current.scale)
        cap = _cap(now)
        now = np.minimum(now, cap)
        strained = self.null.strained(current)
        return Standing(now, cap, self._surplus(now), current.scale, fit.price, strained)

    def gained(self, before: Standing, then: Sequence[Term], by: Term) -> Gain | None:
        """What another set removes, cross-validated, by one term; None where it cannot be."""
        costs, fit = self.null.cross_validated(then, before.scale)
        if costs.size != before.costs.size or not np.all(np.isfinite(costs)):
            return None
        off = before.costs - np.minimum(costs, before.cap)
        saved = (by.effect in before.strained) * (before.price - fit.price)
        return self._gain(off, before.surplus, saved, by)

    def lost(self, full: Standing, rest: Sequence[Term], by: Term) -> Gain:
        """What comes back with a set that one term has left."""
        costs, fit = self.null.cross_validated(rest, full.scale)
        # Whichever constants would have to make up for it.
        strains = bool(set(self.null.strained(fit)) - set(full.strained))
        saved = strains * (fit.price - full.price)
        # It may hurt much in few places, or a little everywhere beside a mishap.
        both = [
            self._gain(np.minimum(costs, most) - full.costs, full.surplus, saved, by)
            for most in (_HURT * full.cap, full.cap)
        ]
        return max(both, key=lambda one: (one.earned, one.share))

    def missed(
        self, full: Standing, chosen: Sequence[Term], rest: Sequence[Term], by: Term
    ) -> Gain:
        """What comes back with simpler terms in one's place, on every stretch: those that are
        fitted cross-validated, and the held-out ones."""
        costs, fit = self.null.cross_validated(rest, full.scale)
        saved = (by.effect in self.null.strained(fit)) * (fit.price - full.price)
        off = np.minimum(costs, full.cap) - full.costs
        held, then = (self._held(self.fit(one), full.scale) for one in (chosen, rest))
        cap = _cap(held)
        unseen = np.minimum(then, cap) - np.minimum(held, cap)
        return self._gain(np.concatenate([off, unseen]), full.surplus, saved, by)

    def tuned(self, chosen: Sequence[Term], at: int) -> Term:
        """The term at a place of a set, with the parameters that were searched fitted beside all of
        it: by Gauss and Newton, as long as that comes closer."""
        best, kept = chosen[at], list(chosen)
        if not best.reach:
            return best
        fit = self.fit(kept)
        scale, cost = fit.scale, math.inf
        while (now := self.cost(fit, scale)) < (1.0 - TIE) * cost:
            best, cost = kept[at], now
            by_name = slopes(best, fit.of(best))
            full = self.fit([*kept, *by_name.values()])
            found = dict(best.fixed)
            for name, slope in by_name.items():
                reach = best.reach[name]
                found[name] += min(max(float(full.of(slope)[0]), -reach), reach)
            kept[at] = best.moved(found)
            fit = self.fit(kept)
        return best

    def cost(self, fit: Solution, scale: float, cap: float = math.inf) -> float:
        """Mean cost of a fit on the stretches that it was fitted to, none above `cap`; nothing
        tells one from another where there is none."""
        costs = self.balance.costs(fit, scale, self.balance.fitted) * fit.dearer
        return float(np.mean(np.minimum(costs, cap))) if costs.size else math.inf

    def glimpsed(self, before: Standing, then: Solution) -> float:
        """The same of a plain fit, as the costs of another set are counted."""
        return self.cost(then, before.scale, before.cap)

    def holds(self, current: Solution, then: Solution, by: Term) -> bool:
        """Whether a term's gain is there on the stretches that nothing was fitted to."""
        before = self._held(current, current.scale)
        if before.size == 0:  # nothing was held out in motion
            return False
        cap = _cap(before)
        before = np.minimum(before, cap)
        off = before - np.minimum(self._held(then, current.scale), cap)
        saved = (by.effect in self.null.strained(current)) * (current.price - then.price)
        return self._gain(off, self._surplus(before), saved, by).kept

    def _gain(self, differences: FloatArray, surplus: float, saved: float, by: Term) -> Gain:
        known = log_odds(self.catalogue.along, by.effect)
        mean = float(np.mean(differences))
        if differences.size < 3:
            return Gain(mean / surplus, 0.0, saved, known)
        spread = float(np.std(differences, ddof=1)) / math.sqrt(differences.size)
        sureness = mean / spread if spread > 0.0 else math.copysign(math.inf, mean)
        return Gain(mean / surplus, sureness, saved, known)

    def _held(self, fit: Solution, scale: float) -> FloatArray:
        """Costs of the held-out stretches."""
        return self.balance.costs(fit, scale, self.balance.judged) * fit.dearer

    def _surplus(self, costs: FloatArray) -> float:
        """Squared residual above the floor.

        The floor may hold what a model would remove: what changes with time does not repeat.
        """
        mean = float(np.mean(costs))
        return max(mean - self.floor**2, _AT_FLOOR * mean, 1e-300)


def _cap(costs: FloatArray) -> float:
    """What the cost of one stretch counts at the most: one mishap must not decide, some may."""
    known = costs[np.isfinite(costs)]
    if known.size == 0:
        return math.inf
    return max(_WORST * float(np.median(known)), 2.0 * float(np.mean(known)))
