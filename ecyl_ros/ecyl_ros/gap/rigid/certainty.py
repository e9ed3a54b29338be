"""How sure a fitted effect of a rigid drive is, and what looks the same in its recording."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from functools import cached_property

import numpy as np

from ...arrays import BoolArray
from ...effects.catalogue import EFFECTS
from ...effects.term import Term
from ..judge.verdict import RARER
from .balance import beside
from .contest import Contest
from .expected import before, log_odds
from .jumps import calm
from .null import Null
from .pulls import price
from .solution import Solution

_CERTAIN = 0.97  # the most that a cause found by effort is believed
_ALIKE = 0.2  # of what is left: sets that differ by less (2 % of its RMS) cannot be told apart
_WORSE = math.hypot(1.0, _ALIKE)  # by which its RMS then differs
_SAME = 0.01  # of the power of columns: they span the same but next to a reversal
_TOLD = 0.1  # odds by the sheet, at which what fits alike is told
_OWN = 0.5  # share of an effect's power that another has to take over to be its like
_OTHER_AXIS = RARER  # weight of another axis that swings, beside a disturbance of fixed frequency
_ERRS = 0.03  # of what is left, or of an effect: by so much models differ that are equally true
# Of itself: by so much the friction of a sound machine may change as it warms up. Temperature
# halves that of robot joints (Bittencourt et al., "An extended friction model to capture load and
# temperature effects in robot joints", 2010).
_WARMS = 0.5


class Certainty:
    """Of the effects of one contest.

    judged: bool[m], rows that gap figures are of; of these count where the effort does not jump.
    floor: standard deviation of what cannot be explained. null: that all sets are fitted beside.
    """

    def __init__(self, null: Null, contest: Contest, judged: BoolArray, floor: float) -> None:
        self.null, self.contest, self.floor = null, contest, floor
        self.balance, self._along = null.balance, null.catalogue.along
        self._calm = calm(self.balance.motion)
        self.judged = self._where_calm(judged)

    def of(self, term: Term) -> tuple[float, float, tuple[str, ...]]:
        """That it, or what looks the same here, acts; that it does itself; what looks the same.

        The first grows with how far behind the best set without it comes; the second is its share
        of the first among what this recording cannot tell from it.
        """
        winner = self.contest.winner
        held = {one.effect for one in self.contest.order}
        own_price = self._price(winner, held - {term.effect})

        def dearer(other: Solution) -> float:
            return self._price(other, held - {term.effect}) - own_price

        best = max(winner.rms(self.judged), 1e-300)
        # The same columns; of a term of several parts what is less common gives but one.
        parts = 1 + bool(term.refines)
        rarity = self._rarity(term.effect)
        rarer = {name: self._rarity(name) - rarity for name in term.alternatives}
        weights = {
            name: RARER ** max(parts, steps) if steps >= 0 else 1.0 for name, steps in rarer.items()
        } | dict.fromkeys(term.bent_by, 0.0)
        known = log_odds(self._along, term.effect)
        without = self.contest.without[term.effect]
        behind = self._behind(without, dearer(without)) + known
        structure, unknown = self._unknown
        own = self._apart(winner, without)
        # With what constants give of it that are off their sheet beside every set.
        whole = math.hypot(own, self._beyond(term))
        waves = {one.key for one in self.contest.order if one.rate}
        for other, rival in self.contest.swaps[term.effect]:
            better = rival.rms(self.judged) * _WORSE < best
            apart = self._apart(winner, rival)
            another = better and apart > _ERRS * whole
            finer = self._finer(rival, winner, term) and not better
            # A friction by direction or speed is friction; a weight or a spring is no load.
            same = term.effect in other.contained and not (another and term.key == "constant")
            if finer or same:
                continue  # a finer form of the same
            if other.effect == term.effect:  # another order or line, as good as the one found
                behind = min(behind, self._behind(rival, dearer(rival)))
                continue
            if other.effect in held and (not other.rate or other.key in waves):
                continue
            simpler = self._within([other], [term])
            near = (
                self._fits_alike(rival)
                or self._as_it_varies(term, other, rival)
                or rival.rms(self.judged) <= _WORSE * best
            )
            near = near and apart <= math.sqrt(_OWN) * whole
            more = dearer(rival)
            odds = _odds(more)
            if not simpler and near and odds >= _TOLD:
                weight = odds * RARER ** max(self._rarity(other.effect) - rarity, 0)
                if another:  # by so much likelier
                    weight *= math.exp(-self._behind(rival, more))
                # Of two constants of the sheet the one is as likely to be wrong as the other.
                if {term.effect, other.effect} <= self.null.catalogue.stated:
                    weights[other.effect] = weight
                weights.setdefault(other.effect, weight)
            else:
                expected = known - log_odds(self._along, other.effect)
                far = self._behind(rival, more)
                if far + expected < behind:
                    far = max(far, self._behind_both(rival, other, held - {term.effect}))
                behind = min(behind, far + expected)
        # What looks the same over a small travel: where this one tells them apart, as told.
        for name in term.alternatives:
            alike = [one for by, one in self.contest.swaps[term.effect] if by.effect == name]
            if alike and min(self._apart(winner, one) for one in alike) > _ERRS * whole:
                weights[name] *= math.exp(-min(self._behind(one, dearer(one)) for one in alike))
                if weights[name] < _TOLD * RARER:
                    del weights[name]
        sure = 1.0 - math.exp(-max(behind, 0.0))
        # Where the effort stood still while the output moved, something else drives it, too.
        acts = min(0.5 + 0.5 * sure, _CERTAIN) * (1.0 - self.balance.motion.standing)
        # It has to stand above the structure that is left; what is rare, above all that is unknown.
        # The sealed study of drives beside structure (kind `structure`) finds it as often as told.
        size = own if rarity > 1 else whole
        above = (unknown if rarity > 1 else structure) / max(size, 1e-9 * best)
        acts = min(acts, 1.0 / (1.0 + 2.0 * math.exp(-known) * above**2))
        others = sum(weights.values()) + (_OTHER_AXIS if term.over_time else 0.0)
        return acts, acts / (1.0 + others), tuple(weights)

    def _where_calm(self, rows: BoolArray) -> BoolArray:
        """Those of rows, bool[m], that no jump of the effort reaches; all where it reaches all."""
        found: BoolArray = rows & self._calm
        return found if found.any() else rows

    def _rarity(self, name: str) -> int:
        return EFFECTS[name].rarity - before(self._along, name)

    def alike(self, rival: Solution) -> bool:
        """Whether a set that has one effect in another's place may as well be the true one."""
        if not self._fits_alike(rival):
            return False
        return _odds(self._price(rival) - self._price(self.contest.winner)) >= _TOLD

    def _fits_alike(self, rival: Solution) -> bool:
        return self._apart(self.contest.winner, rival) <= self._unknown[1]

    def _as_it_varies(self, term: Term, other: Term, rival: Solution) -> bool:
        """Whether a level and friction by speed differ by no more than friction varies.

        At nearly one speed in one direction they do. Nothing is passed twice; the slow rise of a
        speed, which friction itself causes as it warms, says nothing of how it depends on speed.
        """
        side = self._along.side
        forms = {f"{side}_coulomb_friction", f"{side}_viscous_friction"}
        if self._along.both_ways or {term.effect, other.effect} != forms:
            return False
        left = self.contest.winner.residual
        allowed = _WARMS * np.abs(self.contest.without[term.effect].residual - left)
        apart = rival.residual - left
        beyond = apart - np.clip(apart, -allowed, allowed)
        power, more = (float(np.mean(one[self.judged] ** 2)) for one in (left, left + beyond))
        return more <= _WORSE**2 * power

    @cached_property
    def _unknown(self) -> tuple[float, float]:
        """RMS of the structure that is left beyond the floor; of that and what models err by.

        A second unknown of that size would turn one candidate into another, however many samples
        there are.
        """
        best = max(self.contest.winner.priced(self.judged), 1e-300)
        structure = math.sqrt(max(best**2 - self.floor**2, 0.0))
        return structure, math.hypot(structure, _ALIKE * min(best, self.floor))

    def _behind(self, other: Solution, dearer: float) -> float:
        """How far another set comes behind the closest one, as a logarithm of their odds.

        What it leaves more counts as far as models err anyway; the price of its pulls on the sheet,
        by which it is dearer, is twice a logarithm as it stands.
        """
        winner = self.contest.winner
        more = self._left(other) / max(self._left(winner), 1e-300) - 1.0
        return more / _ERRS + 0.5 * dearer

    def _behind_both(self, rival: Solution, other: Term, finer_forms: Collection[str]) -> float:
        """How far a set that has another effect in one's place comes behind the set of both.

        Where both act, one in the other's place may come as close as the one alone; that it does so
        without the first says nothing against that. What is rare, a further effect, is so here too.
        """
        kept = [one for one in self.contest.order if one.effect not in other.refines]
        if len(kept) < len(self.contest.order):
            return -math.inf  # a finer form: that is the set with both
        both = self.null.fit([*kept, other])
        more = self._left(rival) / max(self._left(both), 1e-300) - 1.0
        dearer = self._price(rival, finer_forms) - self._price(both, finer_forms)
        return more / _ERRS + 0.5 * dearer + math.log(RARER)

    def _price(self, fit: Solution, finer_forms: Collection[str] = ()) -> float:
        """Of its pulls on the sheet, see `pulls`."""
        structure = self.contest.winner.bends(self.judged, self.floor)
        return price(self.null, fit, structure, finer_forms)

    def _left(self, fit: Solution) -> float:
        """Root of the robust mean square on all unseen rows: reversals count, too, as far as blows
        may."""
        balance = self.balance
        rows = self._where_calm(balance.judged if balance.judged.any() else balance.usable)
        return math.sqrt(float(np.mean(balance.costs(fit, self.contest.winner.scale, rows))))

    def _beyond(self, term: Term) -> float:
        """RMS of what a sound sheet could not give of what the sheet gives without a term."""
        other = self.contest.without[term.effect]
        return self._apart(other, self.balance.sound(other))

    def _apart(self, one: Solution, other: Solution) -> float:
        """RMS of the difference between what two fits explain."""
        rows = self._where_calm(self.balance.usable)
        return float(np.sqrt(np.mean((one.residual - other.residual)[rows] ** 2)))

    def _finer(self, rival: Solution, winner: Solution, term: Term) -> bool:
        """Whether a rival holds all that the closest set does with `term`, and more."""
        size = sum(one.columns.shape[0] for one in winner.free)
        more = sum(one.columns.shape[0] for one in rival.free) > size
        return more and self._within([term], rival.free)

    def _within(self, simple: Sequence[Term], full: Sequence[Term]) -> bool:
        """Whether terms are a special case of others: then they are a simpler form, no rival."""
        few, many = self.balance.columns(simple), self.balance.columns(full)
        if few.shape[1] >= many.shape[1]:
            return False
        rows = self.balance.usable
        left = beside(few[rows], many[rows])
        return bool(np.sum(left**2) <= _SAME * np.sum(few[rows] ** 2))


def _odds(dearer: float) -> float:
    """Of a set whose pulls on the sheet are dearer than those of another; at most even."""
    return math.exp(-0.5 * max(dearer, 0.0))
