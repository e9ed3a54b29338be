"""How far two effects stand apart once each is fitted: what a diagnosis of a motion will see.

A search looks along straight lines (`predict.separations`), which is cheap. What bends (flanks that
meet elsewhere, a delay that ends between two ticks) the other effect and the sheet take over more
of than lines say, most of all where a search has found the lines to be far apart.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from ..arrays import FloatArray
from ..drive.reference.base import Reference
from ..gap.fit.descent import search, settle, sheet_alone
from ..gap.fit.fit import Fit, Fitter
from ..gap.fit.robust import cost
from ..gap.side_by_side import side_by_side
from .hypotheses import Hypothesis, Pair
from .predict import Experiment, fitter_of_motion

_STEPS = 6  # of the sheet alone at the most, in each stage


def fitted_separations(
    experiment: Experiment,
    reference: Reference,
    duration_s: float,
    pairs: Sequence[Pair],
    straight: Sequence[tuple[float, float]],
) -> list[float]:
    """Of each pair, in noise floors: what one leaves where the other acts, the smaller of the two.

    straight: both along straight lines, which say which of the two that is.
    """

    ways = [
        (one.first, one.second) if there <= back else (one.second, one.first)
        for one, (there, back) in zip(pairs, straight, strict=True)
    ]
    actings = {acting.key: acting for acting, _ in ways}

    def begun(acting: Hypothesis) -> tuple[Fitter, Fit, Fit]:
        """Its recording, its own fit, and the sheet's: those of all pairs in which it acts."""
        faulty = {acting.effect: dict(acting.values)}
        fitter = fitter_of_motion(experiment, reference, duration_s, faulty)
        right = _begun(fitter, acting, fitter.nominal.pulls)
        return fitter, right, sheet_alone(fitter, fitter.nominal, _STEPS)

    known = dict(zip(actings, side_by_side(begun, actings.values()), strict=True))

    def apart(way: tuple[Hypothesis, Hypothesis]) -> float:
        acting, other = way
        fitter, right, alone = known[acting.key]
        # From the size that it is asked for in, which is near: a search from afar, at three times
        # the price, finds separations that are lower by 9 % at the most.
        wrong = settle(fitter, _begun(fitter, other, alone.pulls), alone)
        return _above(fitter, right, wrong, alone)

    return side_by_side(apart, ways)


def separation(fitter: Fitter, acting: Hypothesis, other: Hypothesis, pulls: FloatArray) -> float:
    """What the other effect leaves above the one that acts, each fitted beside the sheet.

    pulls: where the constants of the machine lie on the sheet.
    """
    alone = sheet_alone(fitter, fitter.evaluate({}, pulls), _STEPS)
    right = _closest(fitter, acting, pulls, alone)
    return _above(fitter, right, _closest(fitter, other, alone.pulls, alone), alone)


def _above(fitter: Fitter, right: Fit, wrong: Fit, alone: Fit) -> float:
    """What a fit of the other effect leaves above one of that which acts; alone: the sheet's."""
    # An effect that does worse than the sheet alone would not be taken for anything.
    left = min(_priced(fitter, wrong), _priced(fitter, alone))
    return math.sqrt(max(left - _priced(fitter, right), 0.0))


def _begun(fitter: Fitter, one: Hypothesis, pulls: FloatArray) -> Fit:
    return fitter.evaluate({one.effect: one.values}, pulls)


def _closest(fitter: Fitter, one: Hypothesis, pulls: FloatArray, alone: Fit) -> Fit:
    """The better of two fits: from its own size, constants at `pulls`, and from afar."""
    begun, afar = _begun(fitter, one, pulls), _begun(fitter, one, alone.pulls)
    starts = begun, search(fitter, afar, alone)
    return min((settle(fitter, start, alone) for start in starts), key=lambda fit: fit.fitted)


def _priced(fitter: Fitter, fit: Fit) -> float:
    """Robust mean square on all rows, with the price of the sheet."""
    return fitter.sheet.priced(cost(fit.gap, fitter.replay.usable), fit.pulls)
