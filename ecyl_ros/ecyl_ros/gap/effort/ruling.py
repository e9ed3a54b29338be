"""What may be named: the causes that a contest left, how sure each is, and the verdict."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import maximum_filter1d

from ...effects.catalogue import CATALOGUE
from ..diagnosis import BoolArray, Cause, FittedParameter
from ..verdict import EXPLAINED_SHRINK, NAMED, NO_GAP_RATIO, STRUCTURELESS
from .balance import Balance, Interval, Solution
from .compete import LATE, Contest
from .floor import white_floor
from .terms import Catalogue, Term

# Share of the gap that must be gone for anything to be named. Less than in replay: the floor of a
# real drive is what its best model could reach at all, and friction alone rarely gets there.
_HELPS = 0.5
_CLOSE, _HELPS_CLOSE = 5.0, 0.25  # the same where no more than so many floors are left
_BLOCKS = {"gravity_on_arm": "load"}
_WANDERS = 0.05  # share of the effort that may not repeat where there is to be no gap
_CERTAIN = 0.97  # the most that a cause found by effort is believed
_LEAST = 0.2  # a cause less sure than this is named only if without it (or its like) ...
_MISSED = 0.1  # ... so large a share of the gap comes back
_SMALL = 0.03  # share of the gap that an effect has to take off to be named
_ALIKE = 1.02  # sets that leave so much at the most cannot be told apart
_SLOW = 3.0  # times the speed over which the sign of the speed is softened
_SMEARED = 0.75  # periods of the bandwidth over which the filter spreads what happens at rest
_ENOUGH = 0.5  # share of the judged samples that has to be in motion
_UNLIKELY = 0.33  # weight of what gives the same columns as what is named, but is less common


@dataclass(frozen=True, eq=False)
class Ruling:
    """What a judgement comes to.

    Attributes:
        verdict: one of `VERDICTS`. causes: one per term of the contest, empty unless named.
        base, final: fits of what the file knows, and of what is named with it.
        before, after, best: RMS of what is left on held-out stretches by `base`, by `final`, and by
            the closest set, named or not. shrink: share of what stands above the floor.
        margin: the best rival's RMS over the closest set's.
    """

    verdict: str
    causes: tuple[Cause, ...]
    base: Solution
    final: Solution
    before: float
    after: float
    best: float
    shrink: float
    margin: float

    @property
    def named(self) -> bool:
        """Whether causes are named."""
        return bool(self.causes)


class Judgement:
    """From a contest to a ruling.

    Attributes:
        balance, catalogue, contest: what competed on which recording. The contest is without what
            is not sure enough once `rule` has been called.
        floor, floor_is: standard deviation of what cannot be explained, and what it is.
        judged: bool[m], rows that gap figures are of.
        whole, spans: the closest set fitted to all rows, and 95 % intervals by key of the term.
        notes: what was found but is not named.
    """

    def __init__(
        self, balance: Balance, catalogue: Catalogue, contest: Contest, floor: float, floor_is: str
    ) -> None:
        self.balance, self.catalogue, self.contest = balance, catalogue, contest
        self.floor, self.floor_is = floor, floor_is
        self.white = white_floor(balance, None)
        self.machine, self.motion = catalogue.machine, balance.motion
        self.units = catalogue.units
        judged = balance.judged if balance.judged.any() else balance.usable
        self.judged = _moving(judged, balance, catalogue)
        self.spread = float(np.std(balance.effort[self.judged])) or 1.0
        # Gap figures are those of fits that saw a part; values are fitted anew to all of it.
        self.whole = balance.fit(contest.winner.terms, balance.usable)
        self.spans = balance.intervals(self.whole, balance.usable)
        self.notes: list[str] = []
        self._sure: dict[str, tuple[float, float, float]] = {}
        self._alike: dict[str, tuple[str, ...]] = {}
        self._shares: dict[str, float] = {}

    def rms(self, solution: Solution, rows: BoolArray | None = None) -> float:
        """Of what a solution leaves on `rows`, held-out ones unless told."""
        values = solution.residual[self.judged if rows is None else rows]
        return float(np.sqrt(np.mean(values**2)))

    def _timed(self, before: float) -> float:
        """`before`, less what a shift between effort and motion by a sample or so takes off.

        A command is held for a period after it was recorded; a speed is a difference over two. That
        is how any recording comes about, and no gap.
        """
        base = self.contest.base
        delay = self.catalogue.delay(base.explained(self.balance.nominal))
        delay = dataclasses.replace(delay, low=(-math.inf,))
        fit = self.balance.fit([*base.terms, delay])
        near = abs(float(fit.of(delay)[0])) <= LATE / self.motion.rate_hz
        return min(before, self.rms(fit)) if near else before

    def _helps(self, before: float, best: float, surplus: float) -> bool:
        close = best <= _CLOSE * self.floor
        return before - best >= (_HELPS_CLOSE if close else _HELPS) * surplus

    def rule(self) -> Ruling:
        """Decide what is named. Call once."""
        contest = self.contest
        before, best = self.rms(contest.base), self.rms(contest.winner)
        surplus = max(before - self.floor, 1e-12 * before, 1e-300)
        causes = self._causes(before, surplus)
        # An effort that wanders by itself does not repeat either: that is no floor, but a gap.
        wanders = self.floor > _WANDERS * self.spread and self.floor > 3.0 * self.white
        no_gap = self._timed(before) <= NO_GAP_RATIO * self.floor and not wanders
        if wanders:
            self.notes.append(
                f"{100.0 * self.floor / self.spread:.0f} % of the {self.motion.effort_name} does "
                "not repeat with the motion: it depends on something that was not recorded"
            )
        helps = self._helps(before, best, surplus)
        named = bool(causes) and helps and not no_gap
        if named and any(self._unsure(one) for one in contest.order):
            causes = self._sure_ones(causes, before, surplus)
            contest, best = self.contest, self.rms(self.contest.winner)
            named = bool(causes) and self._helps(before, best, surplus)
        if causes and not named and not no_gap:
            tried = ", ".join(one.title for one in causes)
            self.notes.append(f"closest in the catalogue, but too unsure to be named: {tried}")
        final = contest.winner if named else contest.base
        after = self.rms(final)
        shrink = max(0.0, min(1.0, (before - after) / surplus)) if named else 0.0
        if no_gap:
            verdict = "no_gap"
        elif not named:
            verdict = "unexplained"
        elif shrink >= EXPLAINED_SHRINK and after <= STRUCTURELESS * self.floor:
            verdict = "explained"
        else:
            verdict = "partly_explained"
        rivals = [one for one in contest.rivals if self._rival(one)]
        margin = self.rms(rivals[0]) / best if rivals and best > 0.0 else 1.0
        return Ruling(
            verdict=verdict,
            causes=tuple(causes) if named else (),
            base=contest.base,
            final=final,
            before=before,
            after=after,
            best=best,
            shrink=shrink,
            margin=margin,
        )

    def _causes(self, before: float, surplus: float) -> list[Cause]:
        contest = self.contest
        found = []
        shares: dict[str, float] = {}
        previous = before
        for term, fit in zip(contest.order, contest.path, strict=True):
            now = self.rms(fit)
            lost = self.rms(contest.without[term.effect]) - self.rms(contest.winner)
            known = CATALOGUE.get(term.effect)
            if term.key not in self._sure:  # judged once, beside its rivals and with all others
                acts, sure, alternatives = self._certainty(term, lost)
                self._sure[term.key] = (acts, sure, lost / surplus)
                self._alike[term.key] = alternatives
            shares[term.effect] = shares.get(term.effect, 0.0) + (previous - now) / surplus
            found.append(
                Cause(
                    effect=term.effect,
                    block=known.block if known else _BLOCKS.get(term.effect, "load"),
                    title=known.title if known else term.effect.replace("_", " "),
                    confidence=self._sure[term.key][1],
                    parameters=fitted_parameters(self.spans[term.key]),
                    shrink=min(1.0, (previous - now) / surplus),
                    shrink_alone_lost=min(1.0, lost / surplus),
                    alternatives=self._alike[term.key],
                    excitation=known.excitation if known else "",
                )
            )
            previous = now
        self._shares = shares
        return found

    def _unsure(self, term: Term) -> bool:
        """Not to be named: unsure, small, or hardly missed while much could take its place."""
        acts, sure, missed = self._sure[term.key]
        exchangeable = sure < _LEAST and missed < _MISSED
        return acts < NAMED or exchangeable or self._shares[term.effect] < _SMALL

    def _certainty(self, term: Term, lost: float) -> tuple[float, float, tuple[str, ...]]:
        """That it, or what looks the same here, acts; that it does itself; what looks the same.

        The first grows with how much it is missed and how far behind the best set without it
        comes; the second is its share of the first among what this recording cannot tell from it.
        """
        best = max(self.rms(self.contest.winner), 1e-300)
        held = {one.effect for one in self.contest.order}
        weights = dict.fromkeys(term.alternatives, _UNLIKELY)
        behind = best + max(lost, 0.0)
        for rival in self.contest.rivals:
            finer = {name for one in rival.terms for name in one.refines}
            if term.effect in rival.effects or term.effect in finer:
                continue
            level = self.rms(rival)
            others = [
                one.effect for one in rival.terms if one.effect not in held and one.key != "inertia"
            ]
            if level <= _ALIKE * best and len(others) == 1:
                weights.setdefault(others[0], 1.0)
            else:
                behind = min(behind, level)
        sure = 1.0 - math.exp(-max(behind / best - 1.0, 0.0) / 0.03)
        acts = min(0.5 + 0.5 * sure, _CERTAIN)
        return acts, acts / (1.0 + sum(weights.values())), tuple(weights)

    def _rival(self, one: Solution) -> bool:
        """Whether a set could take the winner's place: it does not contain it."""
        refined = {name for term in one.terms for name in term.refines}
        named = {term.effect for term in self.contest.order}
        return not all(name in one.effects or name in refined for name in named)

    def _sure_ones(self, causes: Sequence[Cause], before: float, surplus: float) -> list[Cause]:
        """The causes that are sure enough, the others only noted and taken out of the model."""
        balance, contest = self.balance, self.contest
        kept = []
        for one, term in zip(causes, contest.order, strict=True):
            if not self._unsure(term):
                kept.append(term)
            else:
                why = f"confidence {one.confidence:.2f}, too unsure"
                if self._shares[term.effect] < _SMALL:
                    why = f"takes off {100.0 * one.shrink:.1f} % of the gap, too little"
                self.notes.append(f"{one.title}: {why} to be named")
        unknown = self.catalogue.unknown()
        path = [balance.fit([*unknown, *kept[: end + 1]]) for end in range(len(kept))]
        self.contest = dataclasses.replace(
            contest, winner=path[-1] if path else contest.base, order=tuple(kept), path=tuple(path)
        )
        self.whole = balance.fit(self.contest.winner.terms, balance.usable)
        self.spans = balance.intervals(self.whole, balance.usable)
        return self._causes(before, surplus)


def _moving(judged: BoolArray, balance: Balance, catalogue: Catalogue) -> BoolArray:
    """`judged` less rests and reversals, where the file holds friction.

    At rest friction holds whatever it must, up to its level: a balance cannot say whether it is as
    modelled.
    """
    motion = balance.motion
    if not any(catalogue.model.coulomb) and not catalogue.model.shapes:
        return judged
    resting = np.abs(motion.velocity) < _SLOW * catalogue.soft
    resting[1:] |= np.signbit(motion.velocity[1:]) != np.signbit(motion.velocity[:-1])
    width = 2 * max(1, round(_SMEARED * motion.rate_hz / motion.bandwidth_hz)) + 1
    near = maximum_filter1d(resting, width)[motion.rows]
    kept: BoolArray = judged & ~near
    return kept if kept.sum() > _ENOUGH * judged.sum() else judged


def fitted_parameters(spans: Sequence[Interval]) -> tuple[FittedParameter, ...]:
    """Intervals as parameters of a cause."""
    return tuple(FittedParameter(*one) for one in spans)
