"""What came out of a competition: the set that won, its order, and what could take its place."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from ...effects.catalogue import RIGID
from ...effects.term import Term
from .sets import Sets
from .solution import Solution
from .terms import bare_beside

_RIVALS = 12


@dataclass(frozen=True, eq=False)
class Contest:
    """What came out.

    nominal: fit of what the file leaves out alone. base: the null, its constants within their
    tolerances. winner: with the effects that earned their place.
    order: their terms in the order of gain. path: fit after each was added. singles: base with one
    effect added, best first. without: the set less one effect, refitted. rivals: the set with one
    effect in another's place. swaps: all of these, by the effect that gave way.
    """

    nominal: Solution
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


def won_by(
    chosen: Sequence[Term],
    sets: Sets,
    base: Solution,
    singles: Sequence[Solution],
    tried: dict[str, float],
) -> Contest:
    """The contest that a set has won."""
    winner = sets.fit(chosen)
    order, path = _ordered(sets, chosen)
    without = {}
    for effect in dict.fromkeys(one.effect for one in chosen):
        rest = [one for one in chosen if one.effect != effect]
        without[effect] = sets.on_sheet(rest, effect, winner)
    swaps = _swaps(sets, chosen, winner)
    rivals = [fit for pairs in swaps.values() for _, fit in pairs]
    rivals.sort(key=lambda one: one.priced(sets.balance.judged))
    return Contest(
        nominal=sets.null.nominal(),
        base=base,
        winner=winner,
        order=order,
        path=path,
        singles=tuple(singles),
        without=without,
        rivals=tuple(rivals[:_RIVALS]),
        swaps=swaps,
        fits=sets.null.fits,
        tried=tried,
    )


def _ordered(sets: Sets, chosen: Sequence[Term]) -> tuple[tuple[Term, ...], tuple[Solution, ...]]:
    """The terms, the one that removes most first, and the fits on the way."""
    left, taken, path = list(chosen), list[Term](), list[Solution]()
    while left:
        fits = [(sets.fit([*taken, one]), one) for one in left]
        fit, one = min(fits, key=lambda item: item[0].priced(sets.balance.judged))
        taken.append(one)
        left.remove(one)
        path.append(fit)
    return tuple(taken), tuple(path)


def _swaps(
    sets: Sets, chosen: Sequence[Term], winner: Solution
) -> dict[str, tuple[tuple[Term, Solution], ...]]:
    """The set with each effect replaced by each other one, by the effect that gave way."""
    found: dict[str, tuple[tuple[Term, Solution], ...]] = {}
    for out in dict.fromkeys(one.effect for one in chosen):
        gone = [one for one in chosen if one.effect == out]
        rest = [one for one in chosen if one.effect != out]
        current = sets.fit(rest)
        pool = [
            one
            for one in sets.candidates(current, rest)
            if one.effect != out or (RIGID[out].several and sets.elsewhere(one, gone))
        ]
        left = sets.left(current, rest)
        # Nor does a motion that tells an effect from no simpler one say that it does not act.
        more = [*sets.catalogue.twins(gone[0], left), *sets.catalogue.untold(left)]
        pool += [one for one in more if one.effect not in {*sets.barred, out}]
        others = [*rest, *gone[1:]]  # of several orders or lines the strongest gives way
        # Without the mean that a sine is given to earn its place: that is an effect itself.
        fits = [(one, sets.on_sheet(_with(others, one), out, winner)) for one in pool]
        found[out] = tuple(sorted(fits, key=lambda pair: pair[1].priced(sets.balance.judged)))
    return found


def _with(others: Sequence[Term], one: Term) -> list[Term]:
    """Terms with one more, in the place of those that it is a finer form of."""
    kept = [other for other in others if other.effect not in one.refines]
    return [*bare_beside([one], kept), one]
