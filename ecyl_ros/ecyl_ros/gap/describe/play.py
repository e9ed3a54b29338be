"""A law played in closed loop: the recording replayed with it, its values fitted there.

A regression along the recorded motion gives the law's form; what counts is what the loop makes of
it. The law moves along the directions in which the recording holds its values, the constants of the
sheet beside it at their price.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...drive.law import Law
from ..compete.earn import AT_FLOOR
from ..fit.fit import CONVERGED, Fitter
from ..fit.newton import Objective, descend, differentiate
from ..fit.robust import LOSS_SCALE, cost
from ..fit.stages import COARSE, EXACT, FINE, LINEAR, MEDIUM, Stage
from ..replay.replay import BoolArray, FloatArray
from .band import half_widths, linear_of, unseen
from .coordinates import Coordinates
from .guess import Guess

# How a law is fitted: stages in turn, each with so many steps at the most.
ROUGHLY = ((COARSE, 2),)
CLOSELY = (
    *((COARSE, 3),) * 2,
    (MEDIUM, 3),
    *((LINEAR, 1),) * 3,  # which samples count is told anew after each step
    *((FINE, 3),) * 3,
    (EXACT, 2),
)
_STILL = 0.98  # of its cost: a stage that leaves more than this is not repeated


@dataclass(frozen=True, eq=False)
class Played:
    """A law as it was fitted in closed loop.

    Attributes:
        law: it. pulls: float64[k], of the sheet beside it.
        gap: float64[signals, n], what is left over the noise floor.
        fitted, judged, left: costs as those of a `Fit`.
        half: float64[values], half the width of the 95 % band of the law's values. pull_half:
            float64[k], the same of the pulls. Of a law that was not fitted to its end 0 and inf.
        unseen: float64[signals, n], what is left on each stretch with what the others tell, over
            the noise floor. Of a law that was not fitted to its end the gap.
    """

    law: Law
    pulls: FloatArray
    gap: FloatArray
    fitted: float
    judged: float
    left: float
    half: FloatArray
    pull_half: FloatArray
    unseen: FloatArray


def evaluate(fitter: Fitter, law: Law, pulls: FloatArray) -> Played:
    """What is left with a law as it is."""
    gap = fitter.replay.playing(law).gap({}, fitter.sheet.constants(pulls))
    left = cost(gap, fitter.held)
    priced = fitter.sheet.priced
    return Played(
        law,
        pulls,
        gap,
        priced(cost(gap, fitter.rows), pulls),
        priced(left, pulls),
        left,
        np.zeros(len(law.values)),
        np.full(len(pulls), np.inf),
        gap,
    )


def play(
    fitter: Fitter,
    guess: Guess,
    port: str,
    pulls: FloatArray,
    how: Sequence[tuple[Stage, int]] = CLOSELY,
) -> Played:
    """Fit a regressed law in closed loop at a port.

    Args:
        fitter: of the recording. guess: the law to begin with. port: where it is played.
        pulls: float64[k], of the sheet, to begin with.
        how: as near as it goes, or `ROUGHLY`, as far as a comparison of ports needs.
    """
    space = Coordinates(fitter, guess, port)
    every = range(len(space.price))
    point = space.begin(pulls)
    best = evaluate(fitter, *space.parted(point))
    gap, slopes = best.gap, np.zeros((len(every), *best.gap.shape))
    secants: FloatArray | None = None
    before, last, ended = math.inf, None, False
    for stage, most in how:
        # Whatever comes of it, these stages say what the law is and how well it is known.
        done = last is not None and math.sqrt(best.fitted) <= fitter.perfect
        if done and not (stage.linear or stage is EXACT):
            continue
        if stage is last and (ended if stage.linear else best.fitted > _STILL * before):
            continue
        fresh = last is None or stage is EXACT
        before, last = best.fitted, stage
        passed: list[tuple[FloatArray, Played]] = []
        objective = _objective(fitter, space, stage, gap, passed)
        if stage.linear:
            secants = slopes.copy() if secants is None else secants
            differentiate(objective, point, gap, slopes, every, space.differences(stage))
            if space.mended is not None:
                space.mended(slopes, point)
            linear = linear_of(gap, slopes, secants, space.price, fitter)
            objective = _of_linear(objective, linear, fitter.rows)
        ended = descend(
            objective,
            point,
            slopes,
            every,
            every,
            space.differences(stage),
            most=most,
            least=CONVERGED,
            fresh=fresh,
            mended=space.mended,
        )
        # The next stage goes on from what this one finds best, as it sees it.
        values = [objective.value(one.gap, where) for where, one in passed]
        point, found = passed[int(np.argmin(values))]
        gap = found.gap
        # All samples together may have led into a hole that spikes have dug; the others lead out.
        others = [found] if stage.linear else [best, *(one for _, one in passed)]
        best = min(others, key=lambda one: one.fitted)
    if last is not EXACT or secants is None:
        return best  # a comparison needs no bands
    linear = linear_of(best.gap, slopes, secants, space.price, fitter)
    seen = slopes[:, :, fitter.rows].reshape(len(slopes), -1)
    half, pull_half = half_widths(
        best.law, best.gap, seen * linear.ravel(), space.along, space.price, guess, fitter
    )
    left = unseen(best.gap, seen, space.price, fitter)
    return dataclasses.replace(best, half=half, pull_half=pull_half, unseen=left)


def _objective(
    fitter: Fitter,
    space: Coordinates,
    stage: Stage,
    gap: FloatArray,
    passed: list[tuple[FloatArray, Played]],
) -> Objective:
    """What a stage brings down from a gap; `passed` takes the points that it tries."""

    def residual(point: FloatArray) -> FloatArray:
        law, pulls = space.parted(point)
        return fitter.replay.playing(law).gap({}, fitter.sheet.constants(pulls))

    def tried(point: FloatArray) -> FloatArray:
        passed.append((point, evaluate(fitter, *space.parted(point))))
        return passed[-1][1].gap

    seen = fitter.blurred(stage.blur_s)
    return Objective(
        residual=residual,
        tried=tried,
        loss_scale=max(LOSS_SCALE * stage.wide, 3.0 * float(np.median(np.abs(seen(gap))))),
        evidence=fitter.sheet.evidence,
        precision=space.price,
        low=space.low,
        high=space.high,
        seen=seen,
    )


def _of_linear(objective: Objective, linear: BoolArray, rows: BoolArray) -> Objective:
    """The objective where these of the fitted samples count alone."""
    return dataclasses.replace(
        objective,
        seen=lambda gap: gap[:, rows][linear],
        evidence=float(linear.mean()) * objective.evidence,
    )


def at_noise(fitter: Fitter, cost: float) -> bool:
    """Whether a cost is no more than a perfect model's."""
    return math.sqrt(cost) <= AT_FLOOR * fitter.perfect
