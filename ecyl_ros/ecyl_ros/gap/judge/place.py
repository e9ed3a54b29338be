"""Causes along the stroke of whose shape the motion showed too little.

A drag that sets in along the stroke, and goes on to where the motion turns back, is no jam by what
was seen: nothing tells whether it ends. A wave along the stroke that was not seen to repeat, beside
another error that grows along it, is one curve with it: no sum of a line and an arc tells that it
is of these two.
"""

from __future__ import annotations

import numpy as np

from ...drive.law import LEAST_PERIODS
from ...effects.catalogue import CATALOGUE
from ..compete.competition import Competition
from ..fit.fit import Fit, Fitter
from ..replay.evidence import gather
from .constancy import without_effects


def open_ended(fit: Fit, fitter: Fitter) -> dict[str, str]:
    """{effect: why it is no cause} of those effects of a fit whose place goes on beyond the stroke
    that was visited, or that are one curve over it."""
    return _beyond(fit, fitter) | _one_curve(fit, fitter)


def _beyond(fit: Fit, fitter: Fitter) -> dict[str, str]:
    """Those whose place the motion did not leave at both ends."""
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


def _one_curve(fit: Fit, fitter: Fitter) -> dict[str, str]:
    """Waves that were not seen to repeat, and what they are one curve with."""
    found: dict[str, str] = {}
    for name in fit.names:
        effect = CATALOGUE[name]
        beside = [one for one in effect.one_curve_with if one in fit.names]
        if effect.period_m is None or not beside:
            continue
        low, high = _visited(fitter)
        waves = (high - low) / effect.period_m(fit.values[name], fitter.replay.drive)
        if waves < LEAST_PERIODS:
            titles = " and ".join(CATALOGUE[one].title for one in (*beside, name))
            said = (
                f"{titles} would improve the fit, but the motion ({1e3 * low:.4g} to "
                f"{1e3 * high:.4g} mm) shows {waves:.2g} waves: together they are one curve"
            )
            found |= dict.fromkeys((*beside, name), said)
    return found


def without_open_ended(competition: Competition, fitter: Fitter) -> tuple[Competition, list[str]]:
    """The competition without such causes in its winner, and what to say of them."""
    found = open_ended(competition.winner, fitter)
    if not found:
        return competition, []
    return without_effects(competition, fitter, list(found)), list(dict.fromkeys(found.values()))


def _visited(fitter: Fitter) -> tuple[float, float]:
    """The ends of the stroke that the rotor went through, m."""
    ends = []
    for part in fitter.replay.parts:
        ratio = part.drive.transmission.rod_per_rotor
        ends.append(ratio * gather(part, {}).rotor_angle_rad[part.usable])
    position = np.concatenate(ends)
    return float(np.nanmin(position)), float(np.nanmax(position))
