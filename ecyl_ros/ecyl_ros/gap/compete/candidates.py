"""The field of candidates: effects and sets of effects upon the sheet alone, fitted as far as pays.

Every effect is started from what the recording shows and replayed once per start; the most
promising are searched for in closed loop, and those that come near are fitted to the end. All may
approach; only what comes near the best goes on.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Iterable, Iterator, Sequence

import numpy as np

from ...effects.catalogue import CATALOGUE, MODULES
from ..fit.descent import approach, close_in, glimpse, polish, sheet_alone, unbent
from ..fit.fit import Fit, Fitter
from ..fit.robust import misfit
from ..fit.stages import MEDIUM
from ..fit.valley import near_floor
from ..side_by_side import side_by_side
from .begin import Beginnings
from .chained import chained
from .earn import AT_FLOOR
from .joint import joined
from .promise import Promise, Promises, best_of_each, foremost

STARTS = 6  # of one effect alone
_STARTS_IN_SETS = 2
KEPT_SINGLES = 9
_NEAR = 4  # steps of a fit from a start near its end
_SETTLING = 3  # polishes at the most
_POLISHING = 8  # steps at the most in each stage; a fit that has ended takes fewer
_KEPT_SETS = 6
_LEADERS = 4  # that approach first; the others have to promise not to be left behind by them
# Times the best cost of those that approached: closing in takes a tenth off it, and nobody in the
# sealed study has come to the front from further behind.
BEHIND = 3.0
_BETTER = 0.9  # of the cost of the sheet alone, from where another fit of it is taken
CLOSE = 2.0  # times the best cost: a runner-up that finer fits may still put first
SEARCHED_SETS = 3
_FURTHER_SETS = 3  # searched besides where they promised less than the best search left
_EXCHANGED = 6  # sets without their leader, and sets that are searched then
_RUNNERS_UP = 5  # alone, that take its place
_TOGETHER = 0.7  # of the cost alone: a set of two that promises to be a pair
_KEPT_RESPONSES = 4  # further sets from responses added up
_KEPT_JOINED = 4  # and from single effects in shares of their sizes
_KEPT_CHAINED = 2  # and from the balance of torque
_SHAKEN_LOOSE = 0.8  # times the least cost of a silent replay
# Work of replays for each second of the recording: 40 s on two cores for the usual 12 s.
_ENOUGH_WORK_PER_S = 1.3e8
_SHEET_STEPS = 12  # of the sheet alone at the most, in each stage


class Candidates:
    """Effects `names` on one recording, and what is known of them so far.

    null: the sheet alone, which every candidate has to beat. library: starts and fits of single
    effects.
    """

    def __init__(self, fitter: Fitter, names: Sequence[str]) -> None:
        self.fitter = fitter
        self.names = list(names)
        self._found_null(sheet_alone(fitter, fitter.nominal, _SHEET_STEPS))

    def _found_null(self, null: Fit) -> None:
        self.null = null
        self.library: list[Fit] = []
        self._promises = Promises(self.fitter, null)
        self._beginnings = Beginnings(self.fitter, self._promises)

    def sheet_from(self, fit: Fit) -> bool:
        """Whether the sheet alone does better from where an effect has led it.

        A constant that is as good as free finds ways that the sheet, held back by its price, has
        missed; any other effect may have, where it can be left out again and less is left than by
        the sheet alone. What comes of it takes the place of `null`.
        """
        if not fit.names:
            return False
        start = self.fitter.without(fit, fit.names)
        free = all(CATALOGUE[name].constant is not None for name in fit.names)
        if not free and start.fitted >= self.null.fitted:
            return False
        found = sheet_alone(self.fitter, start, _SHEET_STEPS)
        if found.fitted > _BETTER * self.null.fitted:
            return False
        self._found_null(found)
        return True

    def costly(self) -> bool:
        """Whether as much was replayed as sets of three should wait for.

        What a replay costs goes by the rate of the drive, by how stiff it is, and by effects that
        make the winding stiff, an inverter's dead time.
        """
        replay = self.fitter.replay
        return replay.work > _ENOUGH_WORK_PER_S * float(replay.time_s[-1])

    def starts(self, base: Fit, names: Iterable[str], most: int) -> list[Fit]:
        """`base` with one more effect, at up to `most` starts that the recording suggests."""
        return self._beginnings.upon(base, list(names), most)

    def search(self, fits: Sequence[Fit], promised: Sequence[float]) -> list[Fit]:
        """Fit each from afar, as long as it is not left behind; best first.

        promised: the cost that each might reach, at best; those that promise most come first.
        """

        def approached(some: Sequence[Fit]) -> list[Fit]:
            return side_by_side(self._approached, some)

        near = approached(fits[:_LEADERS])
        reach = BEHIND * min(one.fitted for one in near)
        others = list(zip(fits, promised, strict=True))[_LEADERS:]
        near += approached([one for one, cost in others if cost < reach])
        left = [one for one, cost in others if cost >= reach]
        reach = BEHIND * min(one.fitted for one in near)
        ahead = [one for one in near if one.fitted <= reach]
        left += [one for one in near if one.fitted > reach]
        closer = side_by_side(lambda one: close_in(self.fitter, one, self.null), ahead)
        return sorted(closer + left, key=lambda one: one.fitted)

    def _approached(self, start: Fit) -> Fit:
        """A fit from afar; where the sheet is bent beyond its tolerances, from it as it is, too."""
        near = approach(self.fitter, start, self.null)
        bent = bool(np.any(np.abs(start.pulls) > 1.0))
        if not bent or near_floor(near, self.fitter):
            return near
        other = approach(self.fitter, self.fitter.evaluate(start.values), self.null)
        return min(near, other, key=lambda one: one.fitted)

    def searched(self, fits: Sequence[Fit]) -> list[Fit]:
        """Fit each from afar; those that have come nearest so far go first."""
        return self.search(fits, [one.fitted for one in fits]) if fits else []

    def near(self, start: Fit) -> Fit:
        """A fit from a start that is near its end, as far as a comparison needs."""
        return self.fitter.fit(start, steps=_NEAR, stage=MEDIUM, known=self.null)

    def refitted(self, start: Fit, pool: Sequence[Fit], winner: Fit) -> Fit:
        """The best fit of a smaller set than `winner`, from `start` or in `pool`.

        To its end only where it comes near the winner: elsewhere it is known to be needed.
        """
        near = self.near(start)
        known = [near, *(one for one in pool if set(one.names) == set(start.names))]
        best = min(known, key=lambda one: one.fitted)
        if best.fitted > BEHIND * winner.fitted:
            return best
        return min([best, *self.polish([best])], key=lambda one: one.fitted)

    def polish(self, fits: Sequence[Fit]) -> list[Fit]:
        """Fit each to the end, with the parameters that only shape its effects."""
        return side_by_side(lambda one: polish(self.fitter, one, _POLISHING), fits)

    def front(self, fits: Sequence[Fit]) -> list[Fit]:
        """The first of `fits`, best first, and a second that comes near it, fitted to the end."""
        near = [one for one in fits[1:2] if one.fitted < CLOSE * fits[0].fitted]
        return self.polish([*fits[:1], *near])

    def _afresh(self, polished: list[Fit]) -> list[Fit]:
        """With the first, where it leaves more than the floor, fitted from an unbent sheet, too."""
        first = polished[0]
        at_floor = misfit(first.fitted) <= AT_FLOOR * self.fitter.perfect_with(first.values)
        if at_floor or not self.fitter.sheet.free(first.values).any():
            return polished
        near = unbent(self.fitter, first)
        if near.fitted > BEHIND * first.fitted:
            return polished
        return [min([first, *self.polish([near])], key=lambda one: one.fitted), *polished[1:]]

    def singles(self, report: Callable[[float], None]) -> list[Fit]:
        """The best fit of each effect alone, best first.

        report: takes the share done.
        """
        started = self.starts(self.null, self.names, STARTS)
        self.library = started
        report(0.3)
        order = self._promises.best(self.null, started)
        kept = foremost(order, KEPT_SINGLES)
        fitted = self.search(self._sized(kept), [one.score for one in kept])
        report(0.7)
        polished = self._afresh(self.front(fitted))
        self.library = started + fitted + polished
        rest = [one.fit for one in order if one not in kept]
        report(1.0)
        return sorted(polished + fitted[len(polished) :] + rest, key=lambda one: one.fitted)

    def _sized(self, promises: Sequence[Promise]) -> list[Fit]:
        return side_by_side(self._promises.sized, promises)

    def larger(self, firsts: Sequence[Fit], singles: Sequence[Fit]) -> list[Fit]:
        """Sets with one effect more than `firsts` have, fitted; best first, empty where there is
        no other effect.

        Upon each of `firsts`; sets of two also from responses added up, from `singles` in shares
        of the sizes they have alone, and from the balance of torque.
        """
        least = min(one.fitted for one in firsts)
        sets, promised = self._upon([one for one in firsts if one.fitted <= BEHIND * least])
        if len(firsts[0].names) == 1:
            keys = {frozenset(one.names) for one in sets}
            pairs = self._promises.pairs(self.library, _KEPT_SETS + _KEPT_RESPONSES)
            pairs = [one for one in pairs if frozenset(one[1]) not in keys][:_KEPT_RESPONSES]
            sets += side_by_side(lambda pair: self.fitter.evaluate(pair[1], self.null.pulls), pairs)
            promised += [left for left, _ in pairs]
            # Causes that hide each other stand in for each other: both come near alone.
            near = [one for one in singles if one.fitted <= BEHIND * singles[0].fitted]
            both = joined(self.fitter, near)[:_KEPT_JOINED]
            both += chained(self.fitter, self.null, self.names)[:_KEPT_CHAINED]
            sets += both
            promised += [one.fitted for one in both]
        return self._best_of(sets, promised) if sets else []

    def _upon(self, firsts: Sequence[Fit]) -> tuple[list[Fit], list[float]]:
        """Each of `firsts` with one more effect, the most promising started, not yet fitted.

        Returns (starts, what each might leave).
        """
        promised: list[Promise] = []
        for rank, first in enumerate(firsts):
            most = STARTS if rank == 0 else _STARTS_IN_SETS
            promised += self._promises.best(first, self.starts(first, self.names, most))
        order = foremost(best_of_each(promised), _KEPT_SETS)
        return self._sized(order), [one.score for one in order]

    def _best_of(self, sets: Sequence[Fit], promised: Sequence[float]) -> list[Fit]:
        """Fit sets of effects, the less promising ones less far; best first.

        Args:
            sets: the most promising first; that one is searched whatever a short fit makes of it.
            promised: the cost that each might reach; those that promised less than the best search
                leaves are searched, too, and pairs that come to far more than either effect alone.
        """
        glimpsed = side_by_side(lambda one: glimpse(self.fitter, one, self.null), sets)
        promise = {id(one): score for one, score in zip(glimpsed, promised, strict=True)}
        first = glimpsed[0]
        glimpsed.sort(key=lambda one: one.fitted)
        if first in glimpsed[SEARCHED_SETS:]:
            glimpsed.remove(first)
            glimpsed.insert(SEARCHED_SETS - 1, first)
        searched = self.searched(glimpsed[:SEARCHED_SETS])
        glimpsed = glimpsed[SEARCHED_SETS:]
        left = min(one.fitted for one in searched)
        if misfit(left) > AT_FLOOR * self.fitter.perfect:
            hopeful = sorted(glimpsed, key=lambda one: promise[id(one)])[:_FURTHER_SETS]
            hopeful = [one for one in hopeful if promise[id(one)] < left]
            glimpsed = [one for one in glimpsed if one not in hopeful]
            hopeful += self._more_together(glimpsed)
            glimpsed = [one for one in glimpsed if one not in hopeful]
            searched = sorted(searched + self.searched(hopeful), key=lambda one: one.fitted)
        polished = self._afresh(self.front(searched))
        rest = searched[len(polished) :] + glimpsed
        return sorted(polished + rest, key=lambda one: one.fitted)

    def exchanged(self, sets: Sequence[Fit]) -> list[Fit]:
        """Sets of two, those near the best also with another effect in the leader's place.

        Best first. The leader, what comes nearest alone, may stand for a true effect that is nearly
        like it, and keep it away: that one shows itself once it begins upon the other effect.
        """
        best = sets[0]
        known = {frozenset(one.names) for one in sets}
        promised = best_of_each(
            one
            for one in self._without_leader(sets)
            if one.score < best.fitted and frozenset(one.fit.names) not in known
        )
        found = self.searched(self._sized(promised[:_EXCHANGED]))
        if not found or found[0].fitted >= best.fitted:
            return list(sets)
        found[:1] = self._afresh(self.polish(found[:1]))
        return sorted([*found, *sets], key=lambda one: one.fitted)

    def _without_leader(self, sets: Sequence[Fit]) -> Iterator[Promise]:
        """What the next best alone may come to in the leader's place, in each set near the best."""
        alone = self._alone()
        leader, *others = sorted(alone, key=lambda name: alone[name])
        near = [one for one in sets if leader in one.names]
        near = [one for one in near if one.fitted < CLOSE * sets[0].fitted]
        having = {frozenset(one.names): one for one in reversed(near)}.values()
        for one in sorted(having, key=lambda one: one.fitted)[:_EXCHANGED]:
            rest = self._rest(one, leader)
            names = [other for other in others[:_RUNNERS_UP] if other not in one.names]
            yield from self._promises.best(rest, self.starts(rest, names, _STARTS_IN_SETS))

    def _alone(self) -> dict[str, float]:
        """The least cost that each effect alone came to."""
        alone: dict[str, float] = {}
        for single in self.library:
            (name,) = single.names
            alone[name] = min(single.fitted, alone.get(name, math.inf))
        return alone

    def _rest(self, fit: Fit, name: str) -> Fit:
        """A fit less one of its effects, the others as they are, with their derivatives."""
        rest = self.fitter.without(fit, [name])
        if fit.jacobian is None:
            return rest
        kept = [row for row, one in enumerate(fit.coordinates) if one.effect != name]
        rows = [*kept, *range(len(fit.coordinates), len(fit.jacobian))]
        return dataclasses.replace(
            rest,
            coordinates=tuple(fit.coordinates[row] for row in kept),
            pulled=fit.pulled,
            jacobian=fit.jacobian[rows],
        )

    def _more_together(self, sets: Sequence[Fit]) -> list[Fit]:
        """The sets of two that come to far more than either effect alone, most of all first."""
        alone = self._alone()

        def share(one: Fit) -> float:
            return one.fitted / min(alone.get(name, self.null.fitted) for name in one.names)

        pairs = sorted((one for one in sets if len(one.names) == 2), key=share)
        return [one for one in pairs if share(one) < _TOGETHER][:_FURTHER_SETS]

    def settled(self, winner: Fit) -> Fit:
        """The winner fitted until it no longer moves."""
        for _ in range(_SETTLING if winner.names else 0):
            if winner.ended:
                break
            better = polish(self.fitter, winner, _POLISHING)
            still = winner.fitted - better.fitted < 0.01 * winner.fitted
            winner = better
            if still:
                break
        return winner

    def shaken_loose(self) -> bool:
        """Whether friction, shaken by noise in the loop, is nearer than any silent replay of it."""
        replay = self.fitter.replay
        if not replay.noise_in_loop:
            return False
        ports = ("rotor_friction", "load_friction")
        names = [name for name in self.names if any(hasattr(MODULES[name], port) for port in ports)]
        silent = self.starts(self.null, names, STARTS)
        replay.shake()
        shaken = side_by_side(lambda one: self.fitter.evaluate(one.values, one.pulls), silent)
        replay.calm()
        nearest = min(one.fitted for one in [self.null, *silent])
        return any(one.fitted < _SHAKEN_LOOSE * nearest for one in shaken)
