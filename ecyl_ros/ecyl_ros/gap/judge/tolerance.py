"""Constants that would be off by less than a data sheet knows them: traces beside a true cause.

Each constant of a healthy machine is off by tenths of a percent. Where a fault brings the drive
near an edge (a delay makes it ring), the replay becomes so sensitive that such a trace shows, and
would earn its place. A screw's lead is known far better and is exempt.
"""

from __future__ import annotations

import math

from ...drive.parameters import DriveParameters
from ...effects.catalogue import CATALOGUE
from ..compete.competition import Competition
from ..fit.fit import Fitter, Values
from .constancy import without_effects

_TOLERANCE = 0.01  # of the logarithm of true over nominal
_EXACT = {"lead_error"}


def traces(values: Values, drive: DriveParameters) -> list[str]:
    """Effects that move a nominal constant by less than its tolerance; all of them: none.

    A change that stands alone is the finding, however small.
    """
    found = []
    for name, given in values.items():
        neutral = CATALOGUE[name].neutral(drive)
        value = given[CATALOGUE[name].parameters[0].name]
        if name in _EXACT or neutral <= 0.0 or value <= 0.0:
            continue
        if abs(math.log(value / neutral)) < _TOLERANCE:
            found.append(name)
    return found if len(found) < len(values) else []


def without_traces(competition: Competition, fitter: Fitter) -> tuple[Competition, list[str]]:
    """The competition without traces in its winner, and what to say of them."""
    winner, drive = competition.winner, fitter.replay.drive
    found = traces(winner.values, drive)
    if not found:
        return competition, []
    notes = []
    for name in found:
        effect = CATALOGUE[name]
        value = winner.values[name][effect.parameters[0].name]
        percent = 100.0 * (value / effect.neutral(drive) - 1.0)
        notes.append(
            f"{effect.title} of {percent:+.2f} % would fit better, but is within its tolerance"
        )
    return without_effects(competition, fitter, found), notes
