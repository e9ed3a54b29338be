"""Which effects close the gap: all of them compete, alone and in sets, judged on what no fit saw.

0. The sheet alone: the constants, each at the price of leaving its tolerance. What follows has them
   free at the same price, and has to beat this.
1. Every effect is started from what the recording shows (regressions, lines, multiples of the
   nominal value) and replayed once per start.
2. The most promising are fitted in closed loop; the best of these with their shape parameters too.
3. Where one effect does not bring the model to the noise floor, sets of two and three are tried:
   candidates come from the responses already at hand, added up with free sizes, from fresh starts
   on what the best single effects leave, and from these in shares of the sizes they have alone. In
   sets of two the next best alone are tried in the place of what is best alone; in the best of
   all, finer forms of its effects begin again.
4. An effect stays in a set only if leaving it out costs clearly more than it adds in freedom.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from ..fit.fit import Fit, Fitter
from .candidates import Candidates
from .earn import at_noise, earns, surely_at_noise
from .forms import Forms

_FIRSTS = 2  # single effects that sets are built upon
_MOST_EFFECTS = 3

Report = Callable[[str, float], None]


@dataclass(frozen=True, eq=False)
class Competition:
    """What came of it.

    Attributes:
        nominal: the model without effects.
        sheet: the same with its constants fitted as far as the data sheet allows; every set of
            effects competes against this.
        singles: the best fit of each effect alone, best first.
        winner: the set that is named, or the nominal model if none earned its place.
        rivals: the best sets of the winner's size that hold another effect, best first.
        leave_one_out: for each effect of the winner, the best fit without it.
        unsearched: how many effects the sets have that were not searched any more, because the
            replays of this recording cost too much; 0 where all were.
    """

    nominal: Fit
    sheet: Fit
    singles: tuple[Fit, ...]
    winner: Fit
    rivals: tuple[Fit, ...]
    leave_one_out: dict[str, Fit]
    unsearched: int = 0


def compete(fitter: Fitter, names: Sequence[str], report: Report) -> Competition:
    """Let the effects `names` compete for the gap that the bare model leaves.

    report: takes a stage and the share done.
    """
    field = Candidates(fitter, names)
    if fitter.divided_by(field.null):
        field = Candidates(fitter, names)
    nominal = fitter.nominal
    forms = Forms(field)
    fitter.test_floor(field.null)
    if field.null is not nominal and surely_at_noise(fitter, field.null):
        return Competition(nominal, field.null, (), field.null, (), {})
    if field.shaken_loose():
        fitter.replay.shake()
    singles = field.singles(lambda share: report("single effects", 0.05 + 0.4 * share))
    if singles and field.sheet_from(singles[0]):
        if at_noise(fitter, field.null):
            return Competition(nominal, field.null, (), field.null, (), {})
        singles = field.singles(lambda share: report("single effects", 0.45 + 0.15 * share))
    null = field.null
    if singles:
        fitter.test_floor(singles[0])
    if null is not nominal and at_noise(fitter, null):
        return Competition(nominal, null, (), null, (), {})
    winner = null
    rivals: list[Fit] = []
    pool = list(singles)
    best = field.settled(forms.simplified(singles[0])) if singles else null
    if singles and earns(fitter, best, null):
        winner = best
        rivals = _others(singles, best)
    # Sets of two are built upon single effects, even where one was told as two simpler ones.
    firsts = singles[:_FIRSTS] if len(best.names) > 1 else [best, *_others(singles, best)][:_FIRSTS]
    size, unsearched = 2, 0
    while not _enough(fitter, best, size) and size <= _MOST_EFFECTS and firsts:
        if size > 2 and field.costly():
            unsearched = size
            break
        report(f"sets of {size}", 0.5 + 0.1 * size)
        fitted = field.larger(firsts, singles)
        if len(winner.names) == size:
            fitted = sorted([winner, *fitted], key=lambda one: one.fitted)
        report(f"sets of {size}", 0.6 + 0.1 * size)
        fitter.test_floor(fitted[0])
        pool += fitted
        best = field.settled(forms.simplified(fitted[0], fitted))
        if size == 2 and not at_noise(fitter, best):
            fitted = field.exchanged([best, *fitted])
            if fitted[0] is not best:
                best = field.settled(forms.simplified(fitted[0], fitted))
        if not at_noise(fitter, best):
            best = forms.finer(best)
        if earns(fitter, best, winner):
            winner = best
        elif len(winner.names) < size:
            break
        best = winner
        rivals = [one for one in fitted if set(one.names) != set(best.names)]
        firsts = [best, *_others(fitted, best)][:_FIRSTS]
        size += 1
    winner, without = _pruned(field, field.settled(winner), pool)
    rivals.sort(key=lambda one: one.judged)
    return Competition(nominal, null, tuple(singles), winner, tuple(rivals), without, unsearched)


def _enough(fitter: Fitter, best: Fit, size: int) -> bool:
    """Whether no set of `size` is needed; one of two may show that the floor is lower."""
    return surely_at_noise(fitter, best) if size == 2 else at_noise(fitter, best)


def _others(fits: Sequence[Fit], best: Fit) -> list[Fit]:
    return [one for one in fits if one.names != best.names]


def _pruned(field: Candidates, winner: Fit, pool: Sequence[Fit]) -> tuple[Fit, dict[str, Fit]]:
    """Take out, one by one, what does not earn its place; with the fits that leave each one out."""
    while True:
        refit = functools.partial(field.refitted, pool=pool, winner=winner)
        without = leave_one_out(field.fitter, winner, field.null, refit)
        idle = [name for name, rest in without.items() if not earns(field.fitter, winner, rest)]
        if not idle or len(winner.names) == 0:
            return winner, without
        winner = min((without[name] for name in idle), key=lambda one: one.fitted)


def leave_one_out(
    fitter: Fitter, winner: Fit, nominal: Fit, refit: Callable[[Fit], Fit]
) -> dict[str, Fit]:
    """For each effect of `winner`, the fit without it: its others fitted again, or `nominal`.

    refit: fits from a start with the others at the winner's values.
    """
    found: dict[str, Fit] = {}
    for name in winner.names:
        found[name] = refit(fitter.without(winner, [name])) if len(winner.names) > 1 else nominal
    return found
