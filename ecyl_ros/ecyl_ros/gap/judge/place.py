"""Causes of a place whose ends the motion did not reach.

A drag that sets in along the stroke, and goes on to where the motion turns back, is no jam by what
was seen: nothing tells whether it ends.
"""

from __future__ import annotations

import numpy as np

from ...effects.catalogue import CATALOGUE
from ..compete.competition import Competition
from ..fit.fit import Fit, Fitter
from ..replay.evidence import gather
from .constancy import without_effects


def open_ended(fit: Fit, fitter: Fitter) -> dict[str, str]:
    """{effect: why it is no cause} of those effects of a fit whose place goes on beyond the stroke
    that was visited."""
    places = {
        name: where(fit.values[name])
        for name in fit.names
        if (where := CATALOGUE[name].place) is not None
    }
    if not places:
        return {}
    low, high = _visited(fitter)
    return {
        name: f"{CATALOGUE[name].title} would improve the fit, but the motion ends "
        f"({1e3 * low:.4g} to {1e3 * high:.4g} mm) within its place"
        for name, (first, last) in places.items()
        if not low < first < last < high
    }


def without_open_ended(competition: Competition, fitter: Fitter) -> tuple[Competition, list[str]]:
    """The competition without such causes in its winner, and what to say of them."""
    found = open_ended(competition.winner, fitter)
    if not found:
        return competition, []
    return without_effects(competition, fitter, list(found)), list(found.values())


def _visited(fitter: Fitter) -> tuple[float, float]:
    """The ends of the stroke that the rotor went through, m."""
    ends = []
    for part in fitter.replay.parts:
        ratio = part.drive.transmission.rod_per_rotor
        ends.append(ratio * gather(part, {}).rotor_angle_rad[part.usable])
    position = np.concatenate(ends)
    return float(np.nanmin(position)), float(np.nanmax(position))
