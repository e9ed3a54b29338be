"""Whether an effect earns its place, and whether noise and the sheet account for what is left."""

from __future__ import annotations

from ..fit.fit import Fit, Fitter
from ..fit.robust import misfit
from .strain import STRAINED, effect_of, most_strained

AT_FLOOR = 1.14  # times a perfect model's misfit: a model this close needs no further effect
EXCUSED = 0.75  # of what can be gone must be, before noise round the loop may excuse the rest
WORTH = 0.6  # a further effect must bring the square of the misfit's surplus below this share ...
LEAST = 0.04  # ... and lower the square itself by this


def at_noise(fitter: Fitter, fit: Fit) -> bool:
    """Whether noise and a sound sheet account for what the fit leaves: no effect is needed."""
    near = misfit(fit.judged) <= AT_FLOOR * fitter.perfect or excused(
        fitter, fit, fitter.perfect_with(fit.values)
    )
    return near and most_strained(fit, fitter) is None


def excused(fitter: Fitter, fit: Fit, sound: float) -> bool:
    """Whether a machine with a fit's effects that is sound otherwise leaves as much as the fit.

    sound: robust misfit of such a machine. The fit has to remove most of what stands above it, and
    something has to: effects that let noise through are no excuse by that alone.
    """
    above = fitter.nominal.judged - sound**2
    removed = fitter.nominal.judged - fit.judged
    return misfit(fit.judged) <= AT_FLOOR * sound and removed >= EXCUSED * above > 0.0


def surely_at_noise(fitter: Fitter, fit: Fit) -> bool:
    """`at_noise`, and no closer fit could prove the floor too high."""
    return at_noise(fitter, fit) and not fitter.floor_unsure


def gone(fitter: Fitter, fit: Fit) -> float:
    """Share of the squared misfit above a perfect nominal model's that a fit removes."""
    perfect = fitter.perfect**2
    before = max(fitter.nominal.judged - perfect, 1e-9)
    return 1.0 - max(fit.judged - perfect, 0.0) / before


def earns(fitter: Fitter, with_it: Fit, without: Fit) -> bool:
    """Whether the larger set lowers the misfit enough, on fitted and on held-out stretches."""
    if without.names and at_noise(fitter, without):
        return False
    if relieves(fitter, with_it, without):
        return True
    perfect = fitter.perfect_with(with_it.values)
    for after, before in ((with_it.fitted, without.fitted), (with_it.judged, without.judged)):
        floor = min(0.95 * perfect**2, after)
        if before - after < LEAST or (after - floor) > WORTH * (before - floor):
            return False
    return True


def relieves(fitter: Fitter, with_it: Fit, without: Fit) -> bool:
    """Whether the larger set frees a constant that the smaller one strains, and leaves none.

    A constant far off its sheet may hardly show in the misfit: others that can nearly be exchanged
    for it share its price. Structure bends the sheet as well: what is left above a perfect model
    counts against the strain, in the same units.
    """
    strain = most_strained(without, fitter)
    if strain is None or effect_of(strain.row, fitter) not in {*with_it.names} - {*without.names}:
        return False
    structure = max(without.left - fitter.perfect_with(without.values) ** 2, 0.0)
    beyond = strain.saved * (1.0 - STRAINED / strain.counted)  # more than a healthy machine may
    if beyond <= fitter.sheet.evidence * structure:
        return False
    closer = with_it.fitted < without.fitted and with_it.judged < without.judged
    return closer and most_strained(with_it, fitter) is None
