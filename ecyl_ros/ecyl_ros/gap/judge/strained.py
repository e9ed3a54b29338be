"""Causes that leave the sheet strained, and hence explain nothing.

A constant that would still have to lie far off its sheet beside the causes is at fault itself, or
stands for what is: where noise accounts for the rest, causes that share the price with it only
bring the constants nearer to what they would be without the fault. (What leaves structure bends the
sheet, too: there the verdict says that something remains.) A constant that no effect stands for
tells as much: a supply that is lower than the model's looks like a back-EMF constant, a resistance
and an inductance, of which two have a name.
"""

from __future__ import annotations

from ..compete.competition import Competition
from ..compete.earn import AT_FLOOR
from ..compete.strain import Strain, furthest
from ..fit.fit import Fit, Fitter
from ..fit.robust import misfit

# How impacts die away is as much the form of the model as a constant of the machine.
_OF_THE_MODEL = "transmission.contact_damping"


def strained(fit: Fit, fitter: Fitter) -> Strain | None:
    """The constant that a fit at the noise floor leaves strained; None where there is none."""
    if misfit(fit.left) > AT_FLOOR * fitter.perfect_with(fit.values):
        return None
    return furthest(fit, fitter, lambda row: fitter.sheet.keys[row] != _OF_THE_MODEL)


def without_causes(competition: Competition, fitter: Fitter) -> Fit:
    """What causes are measured against: the sheet alone, free within its tolerances.

    The nominal model where the sheet alone closes the gap only with a constant far off it: that is
    the gap itself, by another name.
    """
    alone = competition.sheet
    return competition.nominal if strained(alone, fitter) is not None else alone
