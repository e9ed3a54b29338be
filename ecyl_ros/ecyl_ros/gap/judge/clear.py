"""Causes that are not clear of what a healthy machine may have, and hence none.

The 95 % interval of a cause must be clear of the value at which it vanishes; where it gives a
constant another value, clear of the tolerance about it. Nor may the bound of its fit alone hold it
(`pressed`). Of a cause of several sizes one may be nothing (friction in one direction), not all.
"""

from __future__ import annotations

from ...effects.catalogue import CATALOGUE
from ..compete.competition import Competition
from ..fit.fit import Fit, Fitter
from .constancy import without_effects
from .intervals import intervals
from .pressed import pressed
from .strained import strained


def unclear(fit: Fit, fitter: Fitter) -> dict[str, str]:
    """{effect: why it is no cause} of those effects of a fit that are not clear."""
    if not fit.names:
        return {}
    spans, _ = intervals(fit, fitter)
    held_by_bound = pressed(fit, fitter)
    found = {}
    for name in fit.names:
        effect = CATALOGUE[name]
        row = fitter.sheet.index(effect.constant)
        open_ = 0.0 if row is None else float(fitter.sheet.tolerance[row])
        sized = (effect.parameters[0].name,) if effect.sized is None else effect.sized
        neutral = effect.neutral(fitter.replay.nominal)
        held = [spans.get((name, one), (neutral, neutral)) for one in sized]
        if any(f"{name}.{one}" in held_by_bound for one in sized):
            found[name] = "is at the bound of its fit"
        elif sized and all(
            low <= neutral + open_ and high >= neutral - open_ for low, high in held
        ):
            what = "its tolerance" if open_ > 0.0 else "its neutral value"
            found[name] = f"would fit better, but its 95 % interval holds {what}"
    return found


def without_strained(competition: Competition, fitter: Fitter) -> tuple[Competition, list[str]]:
    """The competition without a winner that leaves a constant strained, and what to say of it."""
    winner = competition.winner
    found = strained(winner, fitter)
    if found is None:
        return competition, []
    key, held = fitter.sheet.keys[found.row], float(winner.pulls[found.row])
    if not winner.names:
        return competition, [
            f"the gap closes with {key} {found.pull:+.1f} tolerances off its data sheet (the price "
            f"of that shared by other constants, {held:+.1f}); no effect does clearly better"
        ]
    said = (
        f"{' and '.join(winner.names)} would put {key} {held:+.1f} tolerances off its data sheet: "
        "not named, something else is at fault"
    )
    return without_effects(competition, fitter, winner.names), [said]


def without_unclear(competition: Competition, fitter: Fitter) -> tuple[Competition, list[str]]:
    """The competition without unclear causes in its winner, and what to say of them."""
    found = unclear(competition.winner, fitter)
    if not found:
        return competition, []
    notes = [f"{CATALOGUE[name].title} {why}" for name, why in found.items()]
    return without_effects(competition, fitter, list(found)), notes
