"""The ways a fit is made: the sheet alone, a set of effects from afar, and a set to the end."""

from __future__ import annotations

import dataclasses

from ...arrays import FloatArray
from .coordinate import is_phase
from .fit import CONVERGED, Fit, Fitter
from .stages import COARSE, EXACT, FINE, MEDIUM, Stage
from .valley import along, near_floor, shaped, turned

_ON_THE_WAY = 2.0  # fall of the objective below which a stage that leads on to the next has ended
_SWEEPS = 2  # along size and phase of a periodic effect
_GLIMPSE = 2  # steps of a short look
_ALONE = 2  # times the derivatives of a fit that has no constants beside it: they cost less
_SETTLING = 6  # steps at the most in each stage of a fit that is near its end
_AFRESH = 8  # steps at the most in each stage of a fit from the sheet as it is
_PRICE_MATTERS = 3.0  # times a perfect model's cost


def sheet_alone(fitter: Fitter, start: Fit, steps: int) -> Fit:
    """The model without effects with its constants fitted from `start`, from coarse to fine.

    steps: at the most in each stage.
    """
    best = start
    slopes: dict[Stage, FloatArray] = {}
    for stage in (COARSE, MEDIUM, FINE, EXACT):
        best = fitter.fit(best, steps=steps, stage=stage)
        slopes |= best.slopes
    return dataclasses.replace(best, slopes=slopes) if slopes else best


def approach(fitter: Fitter, start: Fit, known: Fit) -> Fit:
    """Fit from afar, as far as a coarse look at the gap leads.

    known: the sheet alone; its derivatives by the sheet are near enough.

    One parameter: along its valley, which no spike can mislead. Several: the same along each effect
    that has but one, and along size and phase of those that have a phase, then least squares of
    all.
    """
    coordinates = fitter.coordinates_of(start, nuisances=False)
    best = start
    if len(coordinates) == 1:
        best = along(fitter, start, coordinates[0])
        if not _beside_constants(fitter, start):
            return best
        return fitter.fit(best, steps=5, stage=COARSE, known=known, least=_least(fitter))
    # One parameter at a time first, the latest addition to a set before the others.
    for name in reversed(start.names):
        own = [one for one in coordinates if one.effect == name]
        periodic = any(is_phase(one.quantity.name) for one in own)
        for one in _SWEEPS * [own[0], own[-1]] if periodic else own[: len(own) == 1]:
            if not near_floor(best, fitter):
                best = along(fitter, best, one, closely=not periodic)
    best = turned(fitter, best)
    return fitter.fit(best, steps=6, stage=COARSE, known=known, least=_least(fitter))


def close_in(fitter: Fitter, near: Fit, known: Fit) -> Fit:
    """Fit on from where `approach` led, with a finer look; parameters that only shape wait."""
    coordinates = fitter.coordinates_of(near, nuisances=False)
    if len(coordinates) > 1:
        best = turned(fitter, near)
        return fitter.fit(best, steps=4, stage=MEDIUM, known=known, least=_least(fitter))
    if not _beside_constants(fitter, near):
        return near
    best = fitter.fit(near, steps=5, stage=MEDIUM, known=known, least=_least(fitter))
    if coordinates and not near_floor(best, fitter):
        best = along(fitter, best, coordinates[0])
        best = fitter.fit(best, steps=4, stage=MEDIUM, known=known, least=_least(fitter))
    return best


def search(fitter: Fitter, start: Fit, known: Fit) -> Fit:
    """Fit from afar: `approach`, then `close_in`."""
    return close_in(fitter, approach(fitter, start, known), known)


def settle(fitter: Fitter, start: Fit, known: Fit | None = None) -> Fit:
    """Fit on from near the end: from the truth, or from where a search has led.

    known: the sheet alone, settled; its derivatives by the sheet are near enough to begin with.
    """
    near = fitter.fit(start, steps=_SETTLING, stage=MEDIUM, known=known)
    return fitter.fit(near, steps=_SETTLING, stage=FINE)


def glimpse(fitter: Fitter, start: Fit, known: Fit) -> Fit:
    """A short look at where a set leads, by which those are chosen that are searched.

    The first steps are short where flanks meet: the spikes that a small step moves do not overlap.
    """
    free = _beside_constants(fitter, start)
    return fitter.fit(start, steps=_GLIMPSE * (1 if free else _ALONE), stage=MEDIUM, known=known)


def unbent(fitter: Fitter, fit: Fit) -> Fit:
    """Fit once more from the sheet as it is, the effects where `fit` has them.

    Alone the sheet bends as far as it can to stand in for an effect that is not there yet; upon a
    sheet so bent the effect may be stuck where neither is true.
    """
    best = fitter.evaluate(fit.values)
    for stage in (COARSE, MEDIUM):
        best = fitter.fit(best, steps=_AFRESH, stage=stage, least=_least(fitter))
    return best


def _beside_constants(fitter: Fitter, fit: Fit) -> bool:
    """Whether constants of the sheet are fitted beside a set."""
    return bool(fitter.sheet.free(fit.values).any())


def _least(fitter: Fitter) -> float:
    """With constants beside the effects, a stage but the last only leads on to the next."""
    return _ON_THE_WAY if len(fitter.sheet) else CONVERGED


def polish(fitter: Fitter, start: Fit, steps: int) -> Fit:
    """Fit to the end, with the parameters that only shape an effect.

    steps: at the most in each stage.
    """
    best = shaped(fitter, start)
    free = _beside_constants(fitter, start)
    steps = steps if free else _ALONE * steps
    least = _least(fitter)
    for stage in (
        (COARSE, MEDIUM, FINE) if free and not near_floor(best, fitter) else (MEDIUM, FINE)
    ):
        best = fitter.fit(best, steps=steps, nuisances=True, stage=stage, least=least)
    # Far from the floor the price of the sheet decides nothing.
    if free and best.fitted < _PRICE_MATTERS * fitter.perfect**2:
        best = fitter.fit(best, steps=steps, nuisances=True, stage=EXACT)
    return best
