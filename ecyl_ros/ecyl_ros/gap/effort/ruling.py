"""What may be named: the causes that a contest left, how sure each is, and the verdict."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import maximum_filter1d

from ...effects import actuation_delay, load_coulomb_friction, load_viscous_friction
from ...effects.actuation_delay import LATE
from ...effects.catalogue import EFFECTS
from ...effects.term import Interval, Term
from ..diagnosis import BoolArray, Cause, FittedParameter
from ..verdict import EXPLAINED_SHRINK, NAMED, NO_GAP_RATIO, STRUCTURELESS
from .balance import Balance, Solution
from .compete import Contest
from .floor import white_floor
from .neutral import SHEET, SILENT, why_not
from .terms import Catalogue

# Share of the gap that must be gone for anything to be named. Less than in replay: the floor of a
# real drive is what its best model could reach at all, and friction alone rarely gets there.
_HELPS = 0.5
_CLOSE, _HELPS_CLOSE = 5.0, 0.25  # the same where no more than so many floors are left
_WANDERS = 0.05  # share of the effort that may not repeat where there is to be no gap
_CERTAIN = 0.97  # the most that a cause found by effort is believed
_SMALL = 0.03  # share of the gap that an effect has to take off to be named
_ALIKE = 0.2  # of what is left: sets that differ by less (2 % of its RMS) cannot be told apart
_SAME = 0.01  # of the power of columns: they span the same but next to a reversal
_OWN = 0.5  # share of an effect's power that another has to take over to be its like
_MOST = 0.5  # share of what is explained that has to be named to count for the whole
_FLAT = 0.7  # share of the signal that its floor may have: half of the power is unknown beyond
_SLOW = 3.0  # times the speed over which the sign of the speed is softened
_SMEARED = 0.75  # periods of the bandwidth over which the filter spreads what happens at rest
_ENOUGH = 0.5  # share of the judged samples that has to be in motion
_UNLIKELY = 1.0 / 3.0  # weight of an alternative for each step that it is rarer


@dataclass(frozen=True, eq=False)
class Ruling:
    """What a judgement comes to.

    Attributes:
        verdict: one of `VERDICTS`. causes: one per term of the contest, empty unless named.
        base, final: fits of what the file knows, and of what is named with it.
        before, after, best: RMS of what is left on held-out stretches by `base`, by `final`, and by
            the closest set, named or not. shrink: share of what stands above the floor.
        margin: the best rival's RMS over the closest set's. reason: of `not_judgeable`, what
            recording would do.
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
    reason: str = ""

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
        self._sure: dict[str, tuple[float, float]] = {}
        self._alike: dict[str, tuple[str, ...]] = {}
        self._shares: dict[str, float] = {}
        self._shares_all: dict[str, float] = {}
        self._competed = len(contest.order)
        self._void: dict[str, str] = self._voids()

    def rms(self, solution: Solution, rows: BoolArray | None = None) -> float:
        """Of what a solution leaves on `rows`, held-out ones unless told."""
        values = solution.residual[self.judged if rows is None else rows]
        return float(np.sqrt(np.mean(values**2)))

    def _timed(self, before: float) -> float:
        """`before`, less what a shift between effort and motion by a sample or so takes off.

        That is how any recording comes about, and no gap.
        """
        base = self.contest.base
        delay = actuation_delay.term(self.catalogue.along, base.explained(self.balance.nominal))
        delay = dataclasses.replace(delay, low=(-math.inf,))
        fit = self.balance.fit([*base.terms, delay])
        near = abs(float(fit.of(delay)[0])) <= LATE / self.motion.rate_hz
        return min(before, self.rms(fit)) if near else before

    def _helps(self, before: float, best: float, surplus: float) -> bool:
        close = best <= _CLOSE * self.floor
        return before - best >= (_HELPS_CLOSE if close else _HELPS) * surplus

    def rule(self) -> Ruling:
        """Decide what is named. Call once."""
        contest = closest = self.contest
        before, best = self.rms(contest.base), self.rms(contest.winner)
        surplus = max(before - self.floor, 1e-12 * before, 1e-300)
        causes = self._causes(before, surplus)
        reason = ""
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
            if not causes:
                reason = self._undecided(contest)
            # Where what is named makes up most of it, the figures are of the whole set.
            kept = {one.effect for one in causes}
            explained = sum(self._shares_all.values())
            most = sum(self._shares_all[name] for name in kept) >= _MOST * explained
            if not most:
                contest, best = self.contest, self.rms(self.contest.winner)
            named = bool(causes)
        if causes and not named and not no_gap:
            tried = ", ".join(one.title for one in causes)
            self.notes.append(f"closest in the catalogue, but too unsure to be named: {tried}")
        final = contest.winner if named else contest.base
        after = self.rms(final)
        shrink = max(0.0, min(1.0, (before - after) / surplus)) if named else 0.0
        silent = sum(self._void[one.key] in SILENT for one in self.whole.terms)
        within_sheet = not named and not no_gap and self._is_sheet(closest)
        if within_sheet:
            final, after = closest.winner, self.rms(closest.winner)
            shrink = max(0.0, min(1.0, (before - after) / surplus))
        whole = not named or len(self.contest.order) + silent >= self._competed
        signal = float(np.sqrt(np.mean(self.balance.effort[self.judged] ** 2)))
        flat = self.floor > _FLAT * signal and after <= STRUCTURELESS * self.floor
        if flat:
            reason = (
                f"what does not repeat, or noise, is {100.0 * self.floor / signal:.0f} % of the "
                f"{self.motion.effort_name}: a recording with more motion, or load, or with an "
                "effort of less noise would do"
            )
        if flat and not named:
            verdict = "not_judgeable"
        elif no_gap:
            verdict = "no_gap"
        elif within_sheet:
            verdict = "within_sheet"
        elif not named:
            verdict = "not_judgeable" if reason else "unexplained"
        elif (
            shrink >= EXPLAINED_SHRINK
            and after <= STRUCTURELESS * self.floor
            and whole
            and not flat
        ):
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
            reason=reason if verdict == "not_judgeable" else "",
        )

    def _is_sheet(self, closest: Contest) -> bool:
        """Whether constants within their tolerances bring the model to the floor."""
        voids = [self._void[one.key] for one in closest.order]
        near = self.rms(closest.winner) <= STRUCTURELESS * self.floor
        return near and SHEET in voids and all(one in SILENT for one in voids)

    def _voids(self) -> dict[str, str]:
        """Why a term of the closest set is no cause, by its key; empty where it may be one."""
        found, at = {}, 0
        for term in self.whole.terms:
            found[term.key] = why_not(
                self.balance, self.catalogue.along, self.whole, term, self.spans[term.key], at
            )
            at += term.columns.shape[0]
        return found

    def _undecided(self, contest: Contest) -> str:
        """What would tell the like of what was found; empty where nothing sure was found."""
        told = [
            one
            for one in contest.order
            if self._sure[one.key][0] >= NAMED and self._alike[one.key] and not self._void[one.key]
        ]
        if not told:
            return ""
        first = told[0]
        excitation = EFFECTS[first.effect].excitation
        names = " and ".join(
            one.replace("_", " ") for one in (first.effect, *self._alike[first.key])
        )
        wanted = "motion both ways, at several speeds and over more travel"
        if excitation:
            wanted = f"{wanted} ({excitation.rstrip('.')})"
        return f"{names} look alike in this recording; one with {wanted} would tell them"

    def _causes(self, before: float, surplus: float) -> list[Cause]:
        contest = self.contest
        found = []
        shares = self._part()
        self._shares_all = self._shares_all or dict(shares)
        previous = before
        for term, fit in zip(contest.order, contest.path, strict=True):
            now = self.rms(fit)
            lost = self.rms(contest.without[term.effect]) - self.rms(contest.winner)
            known = EFFECTS[term.effect]
            if term.key not in self._sure:  # judged once, beside its rivals and with all others
                acts, sure, alternatives = self._certainty(term, lost)
                self._sure[term.key] = (acts, sure)
                self._alike[term.key] = alternatives
                more = shares.get(term.effect, 0.0)
                shares[term.effect] = max(more, (previous - now) / surplus)
            found.append(
                Cause(
                    effect=term.effect,
                    block=known.block,
                    title=known.title,
                    confidence=self._sure[term.key][1],
                    parameters=fitted_parameters(self.spans[term.key]),
                    shrink=min(1.0, (previous - now) / surplus),
                    shrink_alone_lost=min(1.0, lost / surplus),
                    alternatives=self._alike[term.key],
                    excitation=known.excitation,
                )
            )
            previous = now
        self._shares = {
            name: max(share, self._shares.get(name, 0.0)) for name, share in shares.items()
        }
        return found

    def simplest(self) -> list[Term] | None:
        """The closest set with friction of one level, where its finer forms cannot be told apart.

        That there is friction is then sure, its form is not. None where nothing is to be changed.
        """
        order = list(self.contest.order)
        along = self.catalogue.along
        plain = load_coulomb_friction.term(along)
        for at, term in enumerate(order):
            if plain.effect not in term.refines:
                continue
            lost = self.rms(self.contest.without[term.effect]) - self.rms(self.contest.winner)
            acts, sure, names = self._certainty(term, lost)
            if self._void[term.key] or (acts >= NAMED > sure and names):
                rest = [*order[:at], *order[at + 1 :]]
                viscous = load_viscous_friction.term(along)
                more = [viscous] if viscous.effect in term.refines else []
                return [*rest, plain, *more]
        return None

    def _part(self) -> dict[str, float]:
        """Share of the squared gap that each effect's part of the closest fit accounts for.

        By its covariance with what is explained, so that the shares add up (Pratt, 1987): what two
        effects have in common is not lost to both.
        """
        balance, winner = self.balance, self.contest.winner
        base = self.contest.base.residual[self.judged]
        total = max(float(np.mean(base**2)) - self.floor**2, 1e-300)
        found: dict[str, float] = {}
        for term in self.contest.order:
            part = balance.columns([term])[self.judged] @ winner.of(term)
            share = float(np.mean(part * base)) / total
            found[term.effect] = found.get(term.effect, 0.0) + share
        return found

    def _unsure(self, term: Term) -> bool:
        """Not to be named: void, unsure of itself or among its like, or small."""
        sure = self._sure[term.key][1]
        return bool(self._void[term.key]) or sure < NAMED or self._shares[term.effect] < _SMALL

    def _certainty(self, term: Term, lost: float) -> tuple[float, float, tuple[str, ...]]:
        """That it, or what looks the same here, acts; that it does itself; what looks the same.

        The first grows with how much it is missed and how far behind the best set without it
        comes; the second is its share of the first among what this recording cannot tell from it.
        """
        winner = self.contest.winner
        best = max(self.rms(winner), 1e-300)
        held = {one.effect for one in self.contest.order}
        # The same columns, but less common; of a term of several parts they give but one.
        parts = 1 + bool(term.refines)
        rarity = EFFECTS[term.effect].rarity
        weights = {
            name: _UNLIKELY ** max(parts, EFFECTS[name].rarity - rarity)
            for name in term.alternatives
        } | dict.fromkeys(term.bent_by, 0.0)
        behind = best + max(lost, 0.0)
        # What is left beyond the floor is unknown: a second unknown of that size would turn one
        # candidate into another, however many samples there are.
        unknown = math.hypot(
            math.sqrt(max(best**2 - self.floor**2, 0.0)), _ALIKE * min(best, self.floor)
        )
        own = self._apart(winner, self.contest.without[term.effect])
        for other, rival in self.contest.swaps[term.effect]:
            if term.effect in other.contained or self._finer(rival, winner, term):
                continue  # a finer form of the same
            if other.effect == term.effect:  # another order or line, as good as the one found
                behind = min(behind, max(self.rms(rival), best))
                continue
            if other.effect in held:
                continue
            apart = self._apart(winner, rival)
            simpler = self._within([other], [term])
            near = apart <= unknown or self.rms(rival) <= math.hypot(1.0, _ALIKE) * best
            if not simpler and near and apart <= math.sqrt(_OWN) * own:
                weight = _UNLIKELY ** max(EFFECTS[other.effect].rarity - rarity, 0)
                weights.setdefault(other.effect, weight)
            else:
                behind = min(behind, max(self.rms(rival), best))
        sure = 1.0 - math.exp(-max(behind / best - 1.0, 0.0) / 0.03)
        # Where the effort stood still while the output moved, something else drives it, too.
        acts = min(0.5 + 0.5 * sure, _CERTAIN) * (1.0 - self.motion.standing)
        # What is rare has to stand above what is unknown anyway.
        if rarity > 1:
            acts = min(acts, 1.0 / (1.0 + 2.0 * (unknown / max(own, 1e-9 * best)) ** 2))
        return acts, acts / (1.0 + sum(weights.values())), tuple(weights)

    def _apart(self, one: Solution, other: Solution) -> float:
        """RMS of the difference between what two fits explain."""
        rows = self.balance.usable
        return float(np.sqrt(np.mean((one.residual - other.residual)[rows] ** 2)))

    def _finer(self, rival: Solution, winner: Solution, term: Term) -> bool:
        """Whether a rival holds all that the closest set does with `term`, and more."""
        size = sum(one.columns.shape[0] for one in winner.terms)
        more = sum(one.columns.shape[0] for one in rival.terms) > size
        return more and self._within([term], rival.terms)

    def _within(self, simple: Sequence[Term], full: Sequence[Term]) -> bool:
        """Whether terms are a special case of others: then they are a simpler form, no rival."""
        few, many = self.balance.columns(simple), self.balance.columns(full)
        if few.shape[1] >= many.shape[1]:
            return False
        rows = self.balance.usable
        made = many[rows] @ np.linalg.lstsq(many[rows], few[rows], rcond=None)[0]
        return bool(np.sum((few[rows] - made) ** 2) <= _SAME * np.sum(few[rows] ** 2))

    def _rival(self, one: Solution) -> bool:
        """Whether a set could take the winner's place: it does not contain it."""
        refined = {name for term in one.terms for name in term.refines}
        named = {term.effect for term in self.contest.order}
        return not all(name in one.effects or name in refined for name in named)

    def _sure_ones(self, causes: Sequence[Cause], before: float, surplus: float) -> list[Cause]:
        """The causes that are sure enough; the others are noted.

        All stay in the fit that values come from: what acts and is not named would bend the values
        of what is. Gap figures are of what is named alone.
        """
        balance, contest = self.balance, self.contest
        kept = []
        for one, term in zip(causes, contest.order, strict=True):
            if not self._unsure(term):
                kept.append(term)
            else:
                why = f"confidence {one.confidence:.2f}, too unsure to be named"
                if one.alternatives and self._sure[term.key][0] >= NAMED:
                    others = ", ".join(name.replace("_", " ") for name in one.alternatives)
                    why = f"{why}: it looks like {others} here"
                if self._shares[term.effect] < _SMALL:
                    why = f"takes off {100.0 * one.shrink:.1f} % of the gap, too little to be named"
                why = self._void[term.key] or why
                if why not in SILENT:  # of any recording, and not worth a word
                    self.notes.append(f"{one.title}: {why}")
        unknown = self.catalogue.unknown()
        path = [balance.fit([*unknown, *kept[: end + 1]]) for end in range(len(kept))]
        self.contest = dataclasses.replace(
            contest, winner=path[-1] if path else contest.base, order=tuple(kept), path=tuple(path)
        )
        return self._causes(before, surplus)


def _moving(judged: BoolArray, balance: Balance, catalogue: Catalogue) -> BoolArray:
    """`judged` less rests and reversals, where the file holds friction.

    At rest friction holds whatever it must, up to its level: a balance cannot say whether it is as
    modelled.
    """
    motion = balance.motion
    if not any(catalogue.model.coulomb) and not catalogue.model.shapes:
        return judged
    resting = np.abs(motion.velocity) < _SLOW * catalogue.along.soft
    resting[1:] |= np.signbit(motion.velocity[1:]) != np.signbit(motion.velocity[:-1])
    width = 2 * max(1, round(_SMEARED * motion.rate_hz / motion.bandwidth_hz)) + 1
    near = maximum_filter1d(resting, width)[motion.rows]
    kept: BoolArray = judged & ~near
    return kept if kept.sum() > _ENOUGH * judged.sum() else judged


def fitted_parameters(spans: Sequence[Interval]) -> tuple[FittedParameter, ...]:
    """Intervals as parameters of a cause."""
    return tuple(FittedParameter(*one) for one in spans)
