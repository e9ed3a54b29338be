"""Causes that leave the sheet strained, and hence explain nothing.

A constant that would still have to lie far off its sheet beside the causes is at fault itself, or
stands for what is: where noise accounts for the rest, causes that share the price with it only
bring the constants nearer to what they would be without the fault. (What leaves structure bends the
sheet, too: there the verdict says that something remains.)
"""

from __future__ import annotations

from ..compete.earn import AT_FLOOR
from ..compete.strain import Strain, most_strained
from ..fit.fit import Fit, Fitter
from ..fit.robust import misfit


def strained(fit: Fit, fitter: Fitter) -> Strain | None:
    """The constant that a fit at the noise floor leaves strained; None where there is none."""
    if misfit(fit.left) > AT_FLOOR * fitter.perfect_with(fit.values):
        return None
    return most_strained(fit, fitter)
