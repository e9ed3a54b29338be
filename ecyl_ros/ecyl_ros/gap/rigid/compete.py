"""Effects compete for what the nominal model leaves of the effort: forward selection, look-back.

An effect has to earn its place twice: on stretches that its fit left out (cross-validation among
the fitted ones), and on the held-out stretches, which no fit ever sees; each time by a good part of
what stands above the floor and by more than the stretches differ among themselves.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Sequence

import numpy as np

from ...effects.catalogue import EFFECTS, RIGID
from ...effects.term import Term
from .contest import Contest, won_by
from .null import Null
from .sets import LEAST_GAIN, TIE, Sets
from .solution import Solution
from .terms import free_means, one_mean

_SIMPLER = 0.85  # share of the best gain with which a simpler effect goes first
_AGAIN = 3  # times that columns follow the effort
_MOST = 8  # terms in a set
_SINGLES = 8  # shown alone


def compete(
    null: Null,
    floor: float,
    without: Collection[str] = (),
    progress: Callable[[float], None] = lambda share: None,
) -> Contest:
    """Find the set of effects that explains the balance.

    Args:
        null: of one recording.
        floor: standard deviation below which there is nothing to explain.
        without: effects to do without.
        progress: called with the share done.
    """
    sets = Sets(null, floor, without)
    base = current = sets.fit([])
    chosen: list[Term] = []
    singles: list[Solution] = []
    tried: dict[str, float] = {}
    for number in range(_MOST):
        ranked, shares = _ranked(sets, current, chosen)
        if number == 0:
            singles, tried = [sets.fit([one]) for _, one in ranked[:_SINGLES]], shares
        progress(min(0.9, (number + 1) / 6.0))
        if not ranked:
            break
        first = _first(sets, chosen, ranked, null.strained(current))
        taken = sets.extended(chosen, first)
        chosen = _tuned(sets, _afresh(sets, _look_back(sets, _swapped(sets, taken))))
        current = sets.fit(chosen)
    chosen = _look_back(sets, _likelier(sets, _look_back(sets, chosen)))
    chosen = _tuned(sets, _afresh(sets, _simpler(sets, _in_one(sets, chosen))))
    return won_by(chosen, sets, base, singles, tried)


def concluded(
    null: Null,
    floor: float,
    without: Collection[str],
    contest: Contest,
    chosen: Sequence[Term],
) -> Contest:
    """A contest as if `chosen` had come out of it, less what is not missed beside the others."""
    sets = Sets(null, floor, without)
    kept = [one for one in chosen if one.effect not in sets.barred]
    kept = _likelier(sets, _look_back(sets, kept))
    return won_by(kept, sets, contest.base, contest.singles, contest.tried)


def _ranked(
    sets: Sets, current: Solution, chosen: Sequence[Term]
) -> tuple[list[tuple[float, Term]], dict[str, float]]:
    """Candidates that earn a place beside a set, best first, by the share of the surplus that they
    remove where cross-validated; and the best such share of every effect."""
    candidates = sets.candidates(current, chosen)
    bare = current, sets.standing(current, chosen)
    level = None
    found = []
    best: dict[str, float] = {}
    for one in candidates:
        before, standing = bare
        if RIGID[one.effect].several:  # beside a mean, so that the sine earns its own place
            if level is None:
                held = sets.levelled(chosen)
                fit = sets.fit(held)
                level = (fit, sets.standing(fit, held)) if len(held) > len(chosen) else bare
            before, standing = level
        standing = standing._replace(scale=current.scale)
        # A look at the plain fit first: what removes little there need not be validated.
        more = sets.extended(chosen, one)
        plain = sets.fit(more)
        if float(plain.of(one)[0]) <= one.least:
            continue
        off = float(np.mean(standing.costs)) - sets.glimpsed(standing, plain)
        relieves = one.effect in standing.strained
        if off < (0.0 if relieves else 0.5 * LEAST_GAIN) * standing.surplus:
            continue
        gain = sets.gained(standing, more, one)
        if gain is None:
            continue
        best[one.effect] = max(best.get(one.effect, -math.inf), gain.share)
        if gain.earned and sets.holds(before, plain, one):
            found.append((gain.share, one))
    found.sort(key=lambda pair: -pair[0])
    return found, best


def _first(
    sets: Sets,
    chosen: Sequence[Term],
    ranked: Sequence[tuple[float, Term]],
    strained: Collection[str],
) -> Term:
    """The best candidate; a simpler one that does nearly as well goes first, unless the best would
    earn its place again for what that one leaves.

    Before all others a constant that lies beyond its sheet, for it does whatever comes beside it.
    """
    off = [
        one for one in ranked if one[1].effect in strained and any(RIGID[one[1].effect].constant)
    ]
    ranked = off or ranked
    top, best = ranked[0]
    near = [
        (one.size, EFFECTS[one.effect].rarity, -share, one)
        for share, one in ranked
        if share >= _SIMPLER * top
    ]
    for *_, simpler in sorted(near, key=lambda item: item[:3]):
        if simpler is best or not _clearly_better(sets, chosen, best, simpler):
            return simpler
    return best


def _clearly_better(sets: Sets, chosen: Sequence[Term], best: Term, simpler: Term) -> bool:
    """Whether one candidate removes a good part of what another leaves above the floor, surely."""
    with_simpler, with_best = (sets.extended(chosen, one) for one in (simpler, best))
    left = sets.fit(with_simpler)
    gain = sets.gained(sets.standing(left, with_simpler), with_best, best)
    return gain is not None and gain.earned and sets.holds(left, sets.fit(with_best), best)


def _afresh(sets: Sets, chosen: Sequence[Term]) -> list[Term]:
    """A ripple is a share of the effort, friction one of the load carried, a delay shifts the
    effort: of what the set explains now."""
    kept = list(chosen)
    for _ in range(_AGAIN):
        if all(one.again is None for one in kept):
            break
        fit = sets.fit(kept)
        left = sets.left(fit, kept)
        kept = [one if one.again is None else one.again(left, fit.of(one)) for one in kept]
    return kept


def _tuned(sets: Sets, chosen: Sequence[Term]) -> list[Term]:
    """Parameters that were searched, fitted beside all that acts."""
    kept = list(chosen)
    for at in range(len(kept)):
        kept[at] = sets.tuned(kept, at)
    return kept


def _swapped(sets: Sets, chosen: Sequence[Term]) -> list[Term]:
    """Put others in the place of effects that did best only while the set was smaller."""
    kept = list(chosen)
    for old in list(kept[:-1]):
        rest = [one for one in kept if one is not old]
        full = sets.fit(kept)
        standing = sets.standing(full, kept)
        plain = []
        for one in sets.candidates(sets.fit(rest), rest):
            if one.size <= old.size and one.key != old.key:
                more = sets.extended(rest, one)
                fit = sets.fit(more)
                plain.append((sets.glimpsed(standing, fit), one, more, fit))
        for _, one, more, fit in sorted(plain, key=lambda item: item[0])[:2]:
            gain = sets.gained(standing, more, one)
            again = old.effect in sets.null.strained(fit)  # it is missed on the sheet
            if gain is not None and gain.earned and not again and sets.holds(full, fit, one):
                kept = more
                break
    return kept


def _likelier(sets: Sets, chosen: Sequence[Term]) -> list[Term]:
    """Put another constant of the sheet in the place of one where that comes out likelier.

    Twice an inertia or half a gain leave the same: what the other constants have to be tells them.
    """
    kept, stated = list(chosen), sets.catalogue.stated
    for old in chosen:
        if old.effect not in stated:
            continue
        rest = [one for one in kept if one is not old]
        now = sets.fit(kept)
        standing = sets.standing(now, kept)
        likeliest = sets.glimpsed(standing, now)
        for one in sets.candidates(sets.fit(rest), rest, stated):
            if one.size == old.size and one.key != old.key:
                cost = sets.glimpsed(standing, sets.fit([*rest, one]))
                if cost < (1.0 - TIE) * likeliest:
                    kept, likeliest = [*rest, one], cost
    return kept


def _look_back(sets: Sets, chosen: Sequence[Term]) -> list[Term]:
    """Leave out what is no longer missed."""
    kept = list(chosen)
    while len(kept) > 1:
        standing = sets.standing(sets.fit(kept), kept)
        losses = [
            (sets.lost(standing, [other for other in kept if other is not one], one), one)
            for one in kept
        ]
        idle = [(loss.share, one) for loss, one in losses if not loss.earned]
        if not idle:
            break
        kept.remove(min(idle, key=lambda item: item[0])[1])
    return kept


def _in_one(sets: Sets, chosen: Sequence[Term]) -> list[Term]:
    """Simpler effects give way to the one that they nearly make up where it does better than they
    do: `_simpler` the other way round, for which of them came first decides nothing.
    """
    kinds = {one.effect for one in chosen}
    splits = {name: one.gives_way for name, one in RIGID.items() if one.gives_way is not None}
    for split in sets.candidates(sets.fit(chosen), chosen, splits):
        for simple in splits[split.effect](sets.catalogue.along, False):
            parts = {one.effect for one in simple}
            if parts <= kinds:
                rest = [one for one in chosen if one.effect not in {*parts, *split.refines}]
                whole = one_mean([*rest, split])
                standing = sets.standing(sets.fit(whole), whole)
                if sets.missed(standing, whole, chosen, split).likely:
                    return whole
    return list(chosen)


def _simpler(sets: Sets, chosen: Sequence[Term]) -> list[Term]:
    """An effect gives way to a set of simpler ones where these do as well: by no more than what
    a gain may differ by chance, one standard error (Breiman et al., "Classification and Regression
    Trees", 1984).

    Friction by direction does to friction and a constant load; alone, neither would have been
    enough.
    """
    for split in chosen:
        gives_way = RIGID[split.effect].gives_way
        if gives_way is None or any(one.effect in split.holds for one in chosen):
            continue
        rest = [one for one in chosen if one is not split]
        standing = sets.standing(sets.fit(chosen), chosen)
        for simple in gives_way(sets.catalogue.along, free_means(rest)):
            parts = [sets.catalogue.own(one) for one in simple]
            barred = any(one.effect in sets.barred for one in parts)
            if not barred and not sets.missed(standing, chosen, [*rest, *parts], split).likely:
                return _look_back(sets, [*rest, *parts])
    return list(chosen)
