"""Causes of a place whose ends the motion did not reach.

A drag that sets in along the stroke, and goes on to where the motion turns back, is no jam by what
was seen: nothing tells whether it ends.
"""

from __future__ import annotations

import numpy as np

from ...effects.catalogue import CATALOGUE
from ..compete.compete import Competition
from ..fit.fit import Fitter
from ..replay.evidence import gather
from .constancy import without_effects


def without_open_ended(competition: Competition, fitter: Fitter) -> tuple[Competition, list[str]]:
    """The competition without causes of a place that goes on beyond the stroke that was visited,
    and what to say of them."""
    winner = competition.winner
    places = {
        name: where(winner.values[name])
        for name in winner.names
        if (where := CATALOGUE[name].place) is not None
    }
    if not places:
        return competition, []
    low, high = _visited(fitter)
    notes = {
        name: f"{CATALOGUE[name].title} would improve the fit, but the motion ends "
        f"({1e3 * low:.4g} to {1e3 * high:.4g} mm) within its place"
        for name, (first, last) in places.items()
        if not low < first < last < high
    }
    if not notes:
        return competition, []
    return without_effects(competition, fitter, list(notes)), list(notes.values())


def _visited(fitter: Fitter) -> tuple[float, float]:
    """The ends of the stroke that the rotor went through, m."""
    ends = []
    for part in fitter.replay.parts:
        ratio = part.drive.transmission.rod_per_rotor
        ends.append(ratio * gather(part, {}).rotor_angle_rad[part.usable])
    position = np.concatenate(ends)
    return float(np.nanmin(position)), float(np.nanmax(position))
