"""What may be named: the causes that a contest left, how sure each is, and the verdict."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Collection, Iterator, Sequence
from functools import cached_property

import numpy as np

from ...arrays import FloatArray
from ...effects import constant_load
from ...effects.along import UNMODELLED
from ...effects.catalogue import EFFECTS, RIGID
from ...effects.term import Interval, Term
from ..diagnosis import Cause, FittedParameter
from ..judge.verdict import (
    HELPS,
    NAMED,
    NO_GAP_RATIO,
    STRUCTURELESS,
    in_words,
    named_cause,
    share_of,
    shrink_of,
    told_by,
    verdict_of,
)
from .certainty import Certainty
from .contest import Contest
from .detached import nothing_shown, shows_nothing
from .noise import measurement_noise
from .null import Null
from .rest import moving
from .ruling import Ruling
from .solution import Solution
from .values import Values
from .void import SILENT, why_not

_CLOSE, _HELPS_CLOSE = 5.0, 0.25  # where no more than so many floors are left, less has to be gone
_WANDERS = 0.05  # share of the effort that may not repeat where there is to be no gap
_LIKELY = 0.5  # a gain, or what looks like it, acts rather than not
SMALL = 0.03  # share of the gap that an effect has to remove to be named
_REMAINS = 0.05  # of the power that others leave above the floor: an error of form has another one
_SWINGS = (
    "another axis that swings at the frequency of the periodic disturbance would look the same: a "
    "recording while the others rest would tell"
)
# Twice the inertia by half the gain is the same effort; friction alone is then another.
_COUNTED_ALIKE = {"torque_constant_error", "rotor_inertia_error", "load_inertia_error"}
_FLAT = 0.7  # share of the signal that its floor may have: half of the power is unknown beyond


class Judgement:
    """From a contest to a ruling.

    Attributes:
        null, balance, catalogue, contest: what competed on which recording. The contest is without
            what is not sure enough once `rule` has been called.
        floor, floor_is: standard deviation of what cannot be explained, and what it is.
        judged: bool[m], rows that gap figures are of.
        values: of the closest set, fitted to all rows.
        competed: terms of the contest, before what is not sure enough went.
        notes: what was found but is not named.
    """

    def __init__(self, null: Null, contest: Contest, floor: float, floor_is: str) -> None:
        balance, catalogue = null.balance, null.catalogue
        self.null, self.balance, self.catalogue, self.contest = null, balance, catalogue, contest
        self.floor, self.floor_is = floor, floor_is
        self.white = measurement_noise(catalogue, contest.base)
        self.machine, self.motion = catalogue.machine, balance.motion
        self.units = catalogue.units
        judged = balance.judged if balance.judged.any() else balance.usable
        self.judged = moving(judged, self.motion, catalogue.along)
        self.spread = float(np.std(balance.effort[self.judged])) or 1.0
        # Gap figures are those of fits that saw a part; values are fitted again to all of it.
        self.values = self._valued(null.fit(contest.order, balance.usable))
        self._void = self._voids()
        # An effort that wanders by itself does not repeat either: that is no floor, but a gap, and
        # what is unknown of it may have any form.
        self.wanders = floor > _WANDERS * self.spread and floor > 3.0 * self.white
        known = self.white if self.wanders else floor
        self.certainty = Certainty(null, contest, self.judged, known)
        self.notes: list[str] = []
        self._sure: dict[str, tuple[float, float]] = {}
        self._alike: dict[str, tuple[str, ...]] = {}
        self._shares: dict[str, float] = {}
        self._by_other_gain = list[Values]()
        self.competed = contest.order

    def void(self, term: Term) -> str:
        """Why a term of the closest set is no cause; empty where it may be one."""
        return self._void[term.key]

    def _helps(self, before: float, best: float, surplus: float) -> bool:
        close = best <= _CLOSE * self.floor
        return before - best >= (_HELPS_CLOSE if close else HELPS) * surplus

    def rule(self) -> Ruling:
        """Decide what is named. Call once."""
        contest = closest = self.contest
        nominal = contest.nominal.rms(self.judged)
        before, best = self._sound(contest.base), contest.winner.priced(self.judged)
        surplus = max(before - self.floor, 1e-12 * before, 1e-300)
        causes = self._causes(before, surplus)
        # Where nothing acts for sure that a model could hold, it is no closer than models are.
        floor = self.floor
        signal = float(np.sqrt(np.mean(self.balance.effort[self.judged] ** 2)))
        if not any(self._acts(one) for one in contest.order):
            floor = math.hypot(floor, UNMODELLED * signal)
        reason = beside = ""
        wanders = self.wanders
        # Most of what the file leaves does not repeat: whatever explains the rest, that stays.
        mostly = wanders and nominal < math.sqrt(2.0) * self.floor
        strained = bool(self.null.strained(contest.base))
        # A constant may lie far beyond its sheet and show less than noise does, sample by sample.
        at_floor = nominal <= NO_GAP_RATIO * floor and not strained
        no_gap = at_floor and not wanders
        if wanders:
            share = self.floor / self.spread
            much = f"{100.0 * share:.0f} % of the" if share < 1.0 else "the"
            self.notes.append(
                f"{much} {self.motion.effort_name} does not repeat with the motion: it depends on "
                "something that was not recorded"
            )
        relieves = strained and not self.null.strained(contest.winner)
        helps = relieves or self._helps(before, best, surplus)
        # Where constants within their tolerances do, there is nothing left to explain.
        held = contest.base.rms(self.judged)
        settled = no_gap or (held <= NO_GAP_RATIO * floor and not (strained or mostly))
        # What stands no higher than its floor holds nothing that a cause could take away.
        named = bool(causes) and helps and not (settled or at_floor) and self.balance.moves
        if named and any(self._unsure(one) for one in contest.order):
            causes = self._sure_ones(causes, before, surplus)
            contest = self.contest
            # What goes with what is not named does not count: the rest has to help by itself.
            rest = contest.winner.priced(self.judged)
            relieves = strained and not self.null.strained(contest.winner)
            named = bool(causes) and (relieves or self._helps(before, rest, surplus))
            undecided = self._undecided(closest, {one.effect for one in causes if named})
            if not named and best <= _CLOSE * self.floor:
                reason = undecided
            beside = undecided if named else ""
        if named and any(one.over_time for one in contest.order):
            self.notes.append(_SWINGS)
        final = contest.winner if named else contest.nominal
        after = final.rms(self.judged)
        silent = sum(one in SILENT for one in self._void.values())
        within_sheet = not (named or no_gap or strained or mostly) and self.null.sheet
        within_sheet = within_sheet and held <= STRUCTURELESS * floor
        if within_sheet:
            final, after = closest.base, held
        gap = max(nominal - self.floor, surplus)
        shrink = shrink_of(nominal, after, gap) if named or within_sheet else 0.0
        whole = not named or len(self.contest.order) + silent >= len(self.competed)
        whole = whole and not mostly
        nothing = nothing_shown(self.motion)
        if nothing in self._void.values() and not named:
            reason = f"{nothing}: record a motion that it drives"
        if not self.balance.moves:
            reason = (
                "the output hardly ever moves, and where it stands it shows only what holds it: "
                "record motion"
            )
        flat = self.floor > _FLAT * signal and after <= STRUCTURELESS * self.floor
        if flat:
            reason = (
                f"what does not repeat, or noise, is {100.0 * self.floor / signal:.0f} % of the "
                f"{self.motion.effort_name}: record more motion or load, or an effort with "
                "less noise"
            )
        verdict = verdict_of(
            no_gap=no_gap,
            within_sheet=within_sheet,
            named=named,
            shrink=shrink,
            left=after / self.floor,
            whole=whole,
            flat=flat,
            undecided=bool(reason),
        )
        rivals = [one for one in contest.rivals if self._rival(one)]
        margin = rivals[0].rms(self.judged) / best if rivals and best > 0.0 else 1.0
        return Ruling(
            verdict=verdict,
            causes=tuple(causes) if named else (),
            base=contest.nominal,
            final=final,
            before=nominal,
            after=after,
            best=best,
            shrink=shrink,
            margin=margin,
            reason=reason if verdict == "not_judgeable" else "",
            undecided=beside,
        )

    def _voids(self) -> dict[str, str]:
        """Why a term of the closest set is no cause, by its key; empty where it may be one."""
        found, at = {}, 0
        for term in self.values.fit.free:
            found[term.key] = why_not(
                self.balance,
                self.catalogue.along,
                self.values.fit,
                term,
                self.values.bent[term.key],
                at,
                self.values.structure,
            )
            at += term.columns.shape[0]
            if self._steady(term) and self._detached:
                found[term.key] = found[term.key] or nothing_shown(self.motion)
        return found

    @cached_property
    def _detached(self) -> bool:
        return shows_nothing(self.motion, self.catalogue.model, self._but_a_load())

    def _steady(self, term: Term) -> bool:
        """Whether it is one effort throughout: a load, or friction of one level one way."""
        one_way = not self.catalogue.along.both_ways
        return term.key == "constant" or (one_way and term.key == "coulomb")

    def _but_a_load(self) -> Iterator[tuple[Term, Interval]]:
        """What is fitted or shown but a steady effort, and the interval of its first parameter.

        A wave has no mean, and says nothing of what the mean is.
        """
        for one in self.values.fit.free:
            if not (self._steady(one) or one.rate):
                yield one, self.values.bent[one.key][0]
        more, beside = self.values.beside
        for one in more:
            yield one, beside[one.key][0]

    def _undecided(self, contest: Contest, named: Collection[str]) -> str:
        """What would tell the like of what is missed most but for what is named; empty where
        nothing else that is sure was found."""
        told = [
            one
            for one in contest.order
            if one.effect not in named
            and self._sure[one.key][0] >= NAMED
            and self._alike[one.key]
            and not self._void[one.key]
        ]
        if not told:
            return ""
        first = max(told, key=lambda one: self._sound(contest.without[one.effect]))
        names = (first.effect, *self._alike[first.key])
        if self.catalogue.along.one_frequency:
            return told_by(names, "motion at several frequencies")
        if not any(one in RIGID for one in self._alike[first.key]):
            return (
                f"{in_words(names)} look alike in any motion of a rigid drive; one of them stated "
                "in the drive file would separate them"
            )
        if set(names) <= _COUNTED_ALIKE:
            return (
                f"{in_words(names)} look alike in any motion of a rigid drive whose friction is "
                "known no better; a closer tolerance of one of them would separate them"
            )
        return told_by(
            names,
            "motion both ways, at several speeds and over more travel "
            f"({EFFECTS[first.effect].excitation})",
        )

    def _causes(self, before: float, surplus: float) -> list[Cause]:
        contest = self.contest
        found = []
        shares = self._part()
        previous = before
        for term, fit in zip(contest.order, contest.path, strict=True):
            now = self._sound(fit)
            lost = self._lost(term)
            if term.key not in self._sure:  # judged once, beside its rivals and with all others
                acts, sure, alternatives = self.certainty.of(term)
                others = [one for one in self.values.taken_over(term) if one not in alternatives]
                if sure > 0.0:  # each as good as it, and as what it is alike already
                    sure = acts / (acts / sure + len(others))
                alternatives = (*alternatives, *others)
                self._sure[term.key] = (acts, sure)
                self._alike[term.key] = alternatives
                more = shares.get(term.effect, 0.0)
                shares[term.effect] = max(more, (previous - now) / surplus)
            parameters = [FittedParameter(*one) for one in self._told(term)]
            sure, alternatives = self._sure[term.key][1], self._alike[term.key]
            found.append(
                named_cause(
                    term.effect,
                    parameters,
                    sure,
                    alternatives,
                    share_of(previous - now, surplus),
                    share_of(lost, surplus),
                    needed=EFFECTS[term.effect].excitation,
                )
            )
            previous = now
        self._shares = {
            name: max(share, self._shares.get(name, 0.0)) for name, share in shares.items()
        }
        return found

    def _lost(self, term: Term) -> float:
        """By how much the RMS rises without an effect."""
        without, winner = self.contest.without[term.effect], self.contest.winner
        return self._sound(without) - winner.priced(self.judged)

    def _sound(self, fit: Solution) -> float:
        """RMS that a set leaves whose sheet keeps to its tolerances."""
        return self.balance.sound(fit).priced(self.judged)

    def _part(self) -> dict[str, float]:
        """Share of the squared gap that each effect's part of the closest fit accounts for.

        By its covariance with what is explained, so that the shares add up (Pratt, 1987): what two
        effects have in common is not lost to both. Beside a constant load, if that is more, of the
        gap about its mean: a load has no form to err by, and makes nothing beside it small.
        """
        balance, winner = self.balance, self.contest.winner
        base = self.contest.base.residual[self.judged]
        gaps = [base]
        if any(one.effect == constant_load.EFFECT.name for one in self.contest.order):
            gaps.append(base - np.mean(base))
        found: dict[str, float] = {}
        for term in self.contest.order:
            part = balance.columns([term])[self.judged] @ winner.of(term)
            share = max(self._share(part, gap) for gap in gaps)
            found[term.effect] = found.get(term.effect, 0.0) + share
        return found

    def _share(self, part: FloatArray, gap: FloatArray) -> float:
        return float(np.mean(part * gap)) / max(float(np.mean(gap**2)) - self.floor**2, 1e-300)

    def _acts(self, term: Term) -> bool:
        """Surely there, whether it or one of its like."""
        return self._holds(term, self._sure[term.key][0])

    def _unsure(self, term: Term) -> bool:
        """Not to be named: void, unsure of itself or among its like, or small."""
        return not self._holds(term, self._sure[term.key][1])

    def _holds(self, term: Term, sure: float) -> bool:
        return sure >= NAMED and not self._void[term.key] and not self._small(term)

    def _small(self, term: Term) -> bool:
        """Whether it removes no more of the gap than the others may err by in form; unless it alone
        takes what they leave down to the floor, as no error of theirs would let it."""
        if self._shares[term.effect] >= SMALL:
            return False
        closest = self.certainty.contest  # before what is not sure enough went
        left, without = (
            fit.bends(self.judged, self.floor) ** 2
            for fit in (closest.winner, closest.without[term.effect])
        )
        return left > _REMAINS * without

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
        contest = self.contest
        kept = []
        for one, term in zip(causes, contest.order, strict=True):
            if not self._unsure(term):
                kept.append(term)
            else:
                why = f"confidence {one.confidence:.2f}, too unsure to be named"
                if one.alternatives and self._sure[term.key][0] >= NAMED:
                    others = ", ".join(name.replace("_", " ") for name in one.alternatives)
                    why = f"{why}: it looks like {others} here"
                if self._small(term):
                    why = f"removes {100.0 * one.shrink:.1f} % of the gap, too little to be named"
                why = self._void[term.key] or why
                if why not in SILENT:  # of any recording, and not worth a word
                    self.notes.append(f"{one.title}: {why}")
        # Nor does what is not named, or its like, come in again as a constant off the sheet.
        named = {one.effect for one in kept}
        out = [one for one in contest.order if one.effect not in named]
        like = {name for one in out for name in (one.effect, *self._alike[one.key])}
        null = self.null.holding(like - named)
        path = [null.fit(kept[: end + 1]) for end in range(len(kept))]
        self.contest = dataclasses.replace(
            contest, winner=path[-1] if path else contest.base, order=tuple(kept), path=tuple(path)
        )
        self._by_other_gain = list(self._of_undecided_gain(contest, out))
        gains = {one.effect for one in out if scales(one.effect)}
        if gains:
            self._count_by_the_file([one for one in contest.order if one.effect not in gains])
        return self._causes(before, surplus)

    def _of_undecided_gain(self, contest: Contest, out: Sequence[Term]) -> Iterator[Values]:
        """Values of sets in which a gain acts that is not told from another constant, neither of
        them named: efforts count by it, if it does."""
        for term in out:
            acts, _ = self._sure[term.key]
            if self._void[term.key] or acts < _LIKELY or not self._alike[term.key]:
                continue
            if scales(term.effect):
                yield self.values
            for other, _ in contest.swaps[term.effect]:
                if scales(other.effect) and other.effect in self._alike[term.key]:
                    instead = [other if one is term else one for one in contest.order]
                    yield self._valued(self.null.fit(instead, self.balance.usable))

    def _told(self, term: Term) -> Sequence[Interval]:
        """Its parameters and their intervals, as wide as a gain that is not decided makes them."""
        told: Sequence[Interval] = self.values.told[term.key]
        for values in self._by_other_gain:
            more = values.told.get(term.key)
            if more is not None:
                told = [one.over(other) for one, other in zip(told, more, strict=True)]
        return told

    def _count_by_the_file(self, terms: Sequence[Term]) -> None:
        """Take values from a fit that counts effort as the file does, within its tolerance.

        Another gain scales them all: where none is named, they are told by that of the file.
        """
        fit = self.null.fit(terms, self.balance.usable)
        self.values = self._valued(self.balance.sound(fit))

    def _valued(self, fit: Solution) -> Values:
        return Values(self.balance, self.catalogue.along, self.floor, fit)


def scales(effect: str) -> bool:
    """Whether it stands for a gain of the effort, which all values are counted by."""
    return RIGID[effect].ratio is not None
