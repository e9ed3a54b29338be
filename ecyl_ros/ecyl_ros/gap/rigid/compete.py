"""Effects compete for what the nominal model leaves of the effort: forward selection, look-back.

An effect has to earn its place twice: on stretches that its fit left out (cross-validation among
the fitted ones), and on the held-out stretches, which no fit ever sees; each time by a good part of
what stands above the floor and by more than the stretches differ among themselves.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field

import numpy as np

from ...effects import constant_load
from ...effects.catalogue import EFFECTS, RIGID
from ...effects.term import Term
from ..diagnosis import FloatArray
from .balance import Balance, Solution
from .floor import pairs
from .search import Left
from .terms import Catalogue, free_means

LEAST_GAIN = 0.12  # of the squared residual above the floor
SURE = 2.5  # standard errors over the stretches, fitted ones
_HELD_SURE = 1.3  # the same on the held-out ones, which are fewer: two clear passes, not one
_SIMPLER = 0.85  # share of the best gain with which a simpler effect goes first
_MOST = 8  # terms in a set
_AT_FLOOR = 0.5  # share of the squared residual that may be explained even at the floor
_WORST = 6.0  # times the median stretch: what one stretch counts at the most
_SAME = 5  # terms of one effect of several orders or frequencies


@dataclass(frozen=True, eq=False)
class Contest:
    """What came out.

    base: fit of what the file leaves out alone. winner: with the effects that earned their place.
    order: their terms in the order of gain. path: fit after each was added. singles: base with one
    effect added, best first. without: the set less one effect, refitted. rivals: the set with one
    effect in another's place. swaps: all of these, by the effect that gave way.
    """

    base: Solution
    winner: Solution
    order: tuple[Term, ...]
    path: tuple[Solution, ...]
    singles: tuple[Solution, ...]
    without: dict[str, Solution]
    rivals: tuple[Solution, ...]
    swaps: dict[str, tuple[tuple[Term, Solution], ...]]
    fits: int
    tried: dict[str, float] = field(default_factory=dict)


def compete(
    balance: Balance,
    catalogue: Catalogue,
    floor: float,
    without: Collection[str] = (),
    progress: Callable[[float], None] = lambda share: None,
) -> Contest:
    """Find the set of effects that explains the balance.

    Args:
        balance, catalogue: of one recording.
        floor: standard deviation below which there is nothing to explain.
        without: effects to do without.
        progress: called with the share done.
    """
    return _Run(balance, catalogue, floor, without, progress).run()


def concluded(
    balance: Balance,
    catalogue: Catalogue,
    floor: float,
    without: Collection[str],
    contest: Contest,
    chosen: Sequence[Term],
) -> Contest:
    """A contest as if `chosen` had come out of it, less what is not missed beside the others."""
    run = _Run(balance, catalogue, floor, without, lambda share: None)
    run.fits, run.tried = contest.fits, contest.tried
    return run.conclusion(contest.base, run.pruned(chosen), contest.singles)


class _Run:
    def __init__(
        self,
        balance: Balance,
        catalogue: Catalogue,
        floor: float,
        without: Collection[str],
        progress: Callable[[float], None],
    ) -> None:
        self.balance, self.catalogue, self.floor = balance, catalogue, floor
        self.barred = set(without)
        self.progress = progress
        self.fits = 0
        self.same = pairs(balance, not catalogue.machine.linear and catalogue.along.turns)
        self.unknown = catalogue.unknown()
        self.tried: dict[str, float] = {}

    def run(self) -> Contest:
        base = self._fit([])
        chosen: list[Term] = []
        current = base
        singles: list[Solution] = []
        for number in range(_MOST):
            candidates = self._candidates(current, chosen)
            ranked = self._ranked(current, chosen, candidates, number == 0)
            if number == 0:
                singles = [self._fit([one]) for _, one in ranked[:8]]
            self.progress(min(0.9, (number + 1) / 6.0))
            taken = self._take(current, chosen, ranked)
            if taken is None:
                break
            chosen = self._afresh(self._look_back(self._swapped(taken)))
            current = self._fit(chosen)
        chosen = self._afresh(self._simpler(self._look_back(chosen)))
        return self.conclusion(base, chosen, singles)

    def pruned(self, chosen: Sequence[Term]) -> list[Term]:
        """`chosen` without what is barred or no longer missed."""
        return self._look_back([one for one in chosen if one.effect not in self.barred])

    def conclusion(
        self, base: Solution, chosen: Sequence[Term], singles: Sequence[Solution]
    ) -> Contest:
        """The contest that a set has won."""
        current = self._fit(chosen)
        order, path = self._ordered(chosen)
        less = {}
        for effect in dict.fromkeys(one.effect for one in chosen):
            less[effect] = self._fit([one for one in chosen if one.effect != effect])
        swaps = self._swaps(chosen)
        rivals = sorted(
            (fit for pairs in swaps.values() for _, fit in pairs),
            key=lambda one: one.rms(self.balance.judged),
        )
        return Contest(
            base=base,
            winner=current,
            order=order,
            path=path,
            singles=tuple(singles),
            without=less,
            rivals=tuple(rivals[:12]),
            swaps=swaps,
            fits=self.fits,
            tried=self.tried,
        )

    def _afresh(self, chosen: Sequence[Term]) -> list[Term]:
        """A ripple is a share of the effort: of what the set explains now, ripple included."""
        kept = list(chosen)
        for _ in range(2):
            if all(one.again is None for one in kept):
                break
            explained = self._fit(kept).explained(self.balance.nominal)
            kept = [one if one.again is None else one.again(explained) for one in kept]
        return kept

    def _fit(self, terms: Sequence[Term]) -> Solution:
        self.fits += 1
        return self.balance.fit([*self.unknown, *terms])

    def _surplus(self, costs: FloatArray) -> float:
        """Squared residual above the floor.

        The floor may hold what a model would take off: what changes with time does not repeat.
        """
        mean = float(np.mean(costs))
        return max(mean - self.floor**2, _AT_FLOOR * mean, 1e-300)

    def _left(self, current: Solution, chosen: Sequence[Term]) -> Left:
        orders = [one.effect for one in chosen if one.rate and not one.over_time]
        return Left(
            balance=self.balance,
            along=self.catalogue.along,
            residual=current.residual,
            explained=current.explained(self.balance.nominal),
            same=self.same,
            enough=any(orders.count(name) >= _SAME for name in orders),
        )

    def _candidates(self, current: Solution, chosen: Sequence[Term]) -> list[Term]:
        kinds = [one.effect for one in chosen]
        taken = {one.key for one in chosen}
        finer = {name for one in chosen for name in one.refines}
        return [
            one
            for one in self.catalogue.candidates(self._left(current, chosen))
            if one.effect not in self.barred
            and not self.barred.intersection(one.contained)  # which would bring it back in
            and kinds.count(one.effect) < (_SAME if RIGID[one.effect].several else 1)
            and one.key not in taken
            and one.effect not in finer
        ]

    def _with(self, chosen: Sequence[Term], added: Term) -> list[Term]:
        kept = [one for one in chosen if one.effect not in added.refines]
        return [*(self._levelled(kept) if RIGID[added.effect].several else kept), added]

    def _levelled(self, chosen: Sequence[Term]) -> list[Term]:
        """With a free mean: a sine over part of its period has one, which must not decide."""
        if free_means(chosen) or "constant_load" in self.barred:
            return list(chosen)
        return [*chosen, constant_load.term(self.catalogue.along)]

    def _ranked(
        self,
        current: Solution,
        chosen: Sequence[Term],
        candidates: Sequence[Term],
        first: bool,
    ) -> list[tuple[float, Term]]:
        """Candidates by the share of the surplus that they take off where cross-validated."""
        balance = self.balance
        bare = (current, *self._standing(current, chosen))
        level = None
        found = []
        best: dict[str, float] = {}
        for one in candidates:
            before, now, cap, surplus = bare
            if RIGID[one.effect].several:  # beside a mean, so that the sine earns its own place
                if level is None:
                    held = self._levelled(chosen)
                    fit = self._fit(held)
                    level = (fit, *self._standing(fit, held)) if len(held) > len(chosen) else bare
                before, now, cap, surplus = level
            # A look at the plain fit first: what takes off little there need not be validated.
            plain = self._fit(self._with(chosen, one))
            if float(plain.of(one)[0]) <= one.least:
                continue
            quick = np.minimum(balance.costs(plain, current.scale, balance.fitted), cap)
            if float(np.mean(now)) - float(np.mean(quick)) < 0.5 * LEAST_GAIN * surplus:
                continue
            then = balance.cross_validated([*self.unknown, *self._with(chosen, one)], current.scale)
            self.fits += balance.FOLDS
            if then.size != now.size or not np.all(np.isfinite(then)):
                continue
            gain = now - np.minimum(then, cap)
            share = float(np.mean(gain)) / surplus
            best[one.effect] = max(best.get(one.effect, -math.inf), share)
            if share >= LEAST_GAIN and _sure(gain) >= SURE and self._holds(before, plain):
                found.append((share, one))
        if first:
            self.tried = best
        found.sort(key=lambda pair: -pair[0])
        return found

    def _standing(
        self, current: Solution, chosen: Sequence[Term]
    ) -> tuple[FloatArray, float, float]:
        """Cross-validated costs of a set, capped, the cap, and what stands above the floor."""
        now = self.balance.cross_validated([*self.unknown, *chosen], current.scale)
        cap = _cap(now)
        now = np.minimum(now, cap)
        return now, cap, self._surplus(now)

    def _holds(self, current: Solution, then: Solution) -> bool:
        """Whether the gain is there on the stretches that nothing was fitted to."""
        balance = self.balance
        before = balance.costs(current, current.scale, balance.judged)
        after = balance.costs(then, current.scale, balance.judged)
        cap = _cap(before)
        gain = np.minimum(before, cap) - np.minimum(after, cap)
        surplus = self._surplus(np.minimum(before, cap))
        return float(np.mean(gain)) >= 0.5 * LEAST_GAIN * surplus and _sure(gain) >= _HELD_SURE

    def _take(
        self, current: Solution, chosen: Sequence[Term], ranked: Sequence[tuple[float, Term]]
    ) -> list[Term] | None:
        """The set with the best candidate; a simpler one that does nearly as well goes first."""
        if not ranked:
            return None
        top = ranked[0][0]
        near = [
            (one.size, EFFECTS[one.effect].rarity, -share, one)
            for share, one in ranked
            if share >= _SIMPLER * top
        ]
        picked = min(near, key=lambda item: item[:3])[3]
        return self._with(chosen, picked)

    def _swapped(self, chosen: Sequence[Term]) -> list[Term]:
        """Put others in the place of effects that did best only while the set was smaller."""
        balance = self.balance
        kept = list(chosen)
        for old in list(kept[:-1]):
            rest = [one for one in kept if one is not old]
            full = self._fit(kept)
            now, cap, surplus = self._standing(full, kept)
            plain = []
            for one in self._candidates(self._fit(rest), rest):
                if one.size <= old.size and one.key != old.key:
                    fit = self._fit(self._with(rest, one))
                    costs = np.minimum(balance.costs(fit, full.scale, balance.fitted), cap)
                    plain.append((float(np.mean(costs)), one, fit))
            for _, one, fit in sorted(plain, key=lambda item: item[0])[:2]:
                then = balance.cross_validated([*self.unknown, *self._with(rest, one)], full.scale)
                self.fits += balance.FOLDS
                if then.size != now.size or not np.all(np.isfinite(then)):
                    continue
                gain = now - np.minimum(then, cap)
                better = float(np.mean(gain)) >= LEAST_GAIN * surplus and _sure(gain) >= SURE
                if better and self._holds(full, fit):
                    kept = self._with(rest, one)
                    break
        return kept

    def _look_back(self, chosen: Sequence[Term]) -> list[Term]:
        """Leave out what is no longer missed."""
        balance = self.balance
        kept = list(chosen)
        while len(kept) > 1:
            full = self._fit(kept)
            now, cap, surplus = self._standing(full, kept)
            weakest, least = None, math.inf
            for one in kept:
                rest = [other for other in kept if other is not one]
                then = balance.cross_validated([*self.unknown, *rest], full.scale)
                # Leaving it out may hurt in few places, but there as much as it likes.
                loss = np.minimum(then, 4.0 * cap) - now
                self.fits += balance.FOLDS
                share = float(np.mean(loss)) / surplus
                missed = share >= LEAST_GAIN and _sure(loss) >= SURE
                if not missed and share < least:
                    weakest, least = one, share
            if weakest is None:
                break
            kept.remove(weakest)
        return kept

    def _simpler(self, chosen: Sequence[Term]) -> list[Term]:
        """An effect gives way to a set of simpler ones where these do as well.

        Friction by direction does to friction and a constant load; alone, neither would have been
        enough.
        """
        for split in chosen:
            gives_way = RIGID[split.effect].gives_way
            if gives_way is None or any(one.effect in split.holds for one in chosen):
                continue
            balance = self.balance
            rest = [one for one in chosen if one is not split]
            full = self._fit(chosen)
            now, cap, surplus = self._standing(full, chosen)
            for parts in gives_way(self.catalogue.along, free_means(rest)):
                if any(one.effect in self.barred for one in parts):
                    continue
                then = balance.cross_validated([*self.unknown, *rest, *parts], full.scale)
                self.fits += balance.FOLDS
                loss = np.minimum(then, 4.0 * cap) - now
                share = float(np.mean(loss)) / surplus
                if share < LEAST_GAIN or _sure(loss) < SURE:
                    return [*rest, *parts]
        return list(chosen)

    def _ordered(self, chosen: Sequence[Term]) -> tuple[tuple[Term, ...], tuple[Solution, ...]]:
        """The terms from the one that takes off most on, and the fits on the way."""
        left, taken, path = list(chosen), list[Term](), list[Solution]()
        while left:
            fits = [(self._fit([*taken, one]), one) for one in left]
            fit, one = min(fits, key=lambda item: item[0].rms(self.balance.judged))
            taken.append(one)
            left.remove(one)
            path.append(fit)
        return tuple(taken), tuple(path)

    def _swaps(self, chosen: Sequence[Term]) -> dict[str, tuple[tuple[Term, Solution], ...]]:
        """The set with each effect replaced by each other one, by the effect that gave way."""
        found: dict[str, tuple[tuple[Term, Solution], ...]] = {}
        for out in dict.fromkeys(one.effect for one in chosen):
            gone = [one for one in chosen if one.effect == out]
            rest = [one for one in chosen if one.effect != out]
            current = self._fit(rest)
            pool = [
                one
                for one in self._candidates(current, rest)
                if one.effect != out or self._elsewhere(one, gone)
            ]
            twins = self.catalogue.twins(gone[0], self._left(current, rest))
            pool += [one for one in twins if one.effect not in self.barred]
            others = [*rest, *gone[1:]]  # of several orders or lines the strongest gives way
            # Without the mean that a sine is given to earn its place: that is an effect itself.
            pairs = [
                (one, self._fit([*(o for o in others if o.effect not in one.refines), one]))
                for one in pool
            ]
            found[out] = tuple(sorted(pairs, key=lambda pair: pair[1].rms(self.balance.judged)))
        return found

    def _elsewhere(self, one: Term, found: Sequence[Term]) -> bool:
        """Whether a line is another one than those found: more than one of its widths away."""
        if not RIGID[one.effect].several:
            return False
        along = np.ptp(self.balance.time_s) if one.over_time else 0.0
        along = along or float(np.ptp(self.catalogue.along.turn.angle)) / math.tau
        return all(abs(one.rate - other.rate) * along > 2.0 for other in found)


def _cap(costs: FloatArray) -> float:
    """What the cost of one stretch counts at the most: one mishap must not decide, some may."""
    known = costs[np.isfinite(costs)]
    if known.size == 0:
        return math.inf
    return max(_WORST * float(np.median(known)), 2.0 * float(np.mean(known)))


def _sure(gain: FloatArray) -> float:
    """Mean over its standard error."""
    if gain.size < 3:
        return 0.0
    spread = float(np.std(gain, ddof=1)) / math.sqrt(gain.size)
    return float(np.mean(gain)) / spread if spread > 0.0 else math.copysign(math.inf, gain.mean())
