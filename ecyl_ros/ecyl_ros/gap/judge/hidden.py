"""Causes that would not show by themselves, beside one that makes much of what does not show.

A loop at the edge of stability, or a load that rattles, makes floors of differences that every
healthy machine has. A second effect that takes these up, but is itself below what the floor of the
nominal replay hides, is one of them.
"""

from __future__ import annotations

from ...effects.catalogue import CATALOGUE
from ..compete.competition import Competition
from ..compete.earn import excused
from ..fit.fit import Fitter
from .constancy import without_effects


def without_hidden(competition: Competition, fitter: Fitter) -> tuple[Competition, list[str]]:
    """The competition without causes that the floor hides, and what to say of them.

    They stay where what is left without them is more than a healthy machine leaves.
    """
    winner = competition.winner
    if len(winner.names) < 2:
        return competition, []
    small = [name for name in winner.names if fitter.hidden.small({name: winner.values[name]})]
    if not 0 < len(small) < len(winner.names):
        return competition, []
    found = without_effects(competition, fitter, small)
    rest = found.winner
    if not rest.names or not excused(fitter, rest, fitter.sound_with(rest)):
        return competition, []
    titles = " and ".join(CATALOGUE[one].title for one in rest.names)
    return found, [
        f"{CATALOGUE[name].title} would improve the fit, but at a size that does not show "
        f"without {titles}: not named"
        for name in small
    ]
