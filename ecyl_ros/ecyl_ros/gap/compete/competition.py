"""What came of a competition, and what of a set does not earn its place."""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from ..fit.fit import Fit, Fitter
from .candidates import Candidates
from .earn import at_noise, earns, surely_at_noise


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


def enough(fitter: Fitter, best: Fit, size: int) -> bool:
    """Whether no set of `size` is needed; one of two may show that the floor is lower."""
    return surely_at_noise(fitter, best) if size == 2 else at_noise(fitter, best)


def others(fits: Sequence[Fit], best: Fit) -> list[Fit]:
    """Fits of other sets than `best`."""
    return [one for one in fits if one.names != best.names]


def pruned(field: Candidates, winner: Fit, pool: Sequence[Fit]) -> tuple[Fit, dict[str, Fit]]:
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
