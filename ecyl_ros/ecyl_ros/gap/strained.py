"""Causes that leave the sheet strained, and hence explain nothing.

A constant that would still have to lie far off its sheet beside the causes is at fault itself, or
stands for what is: where noise accounts for the rest, causes that share the price with it only
bring the constants nearer to what they would be without the fault. (What leaves structure bends the
sheet, too: there the verdict says that something remains.)
"""

from __future__ import annotations

from .compete import Competition
from .constancy import without_effects
from .earn import AT_FLOOR, STRAINED
from .fit import Fitter
from .robust import misfit
from .strain import effect_of, strains


def without_strained(competition: Competition, fitter: Fitter) -> tuple[Competition, list[str]]:
    """The competition without a winner that leaves a constant strained, and what to say of it."""
    winner = competition.winner
    if misfit(winner.left) > AT_FLOOR * fitter.perfect_with(winner.values):
        return competition, []
    found = [one for one in strains(winner, fitter) if effect_of(one.row, fitter)]
    if not found or found[0].saved <= STRAINED:
        return competition, []
    off = float(winner.pulls[found[0].row])
    where = f"{fitter.sheet.keys[found[0].row]} {off:+.1f} tolerances off its data sheet"
    if not winner.names:
        return competition, [f"the gap would be gone with {where}, and no named cause does as well"]
    said = f"{' and '.join(winner.names)} would leave {where}: something else is at fault"
    return without_effects(competition, fitter, winner.names), [said]
