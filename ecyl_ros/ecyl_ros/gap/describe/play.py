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

from ...arrays import BoolArray, FloatArray
from ...drive.law import Law
from ..compete.earn import AT_FLOOR
from ..fit.fit import CONVERGED, Fitter
from ..fit.newton import Objective, descend, differentiate
from ..fit.robust import LOSS_SCALE, cost
from ..fit.stages import COARSE, EXACT, FINE, LINEAR, MEDIUM, Stage
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
)
_EXACTLY = (EXACT, 2)
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


class Playing:
    """A law while it is fitted in closed loop at a port, each stage going on from the last.

    Attributes:
        best: the law that leaves least, of all that were tried.
    """

    def __init__(self, fitter: Fitter, guess: Guess, port: str, pulls: FloatArray) -> None:
        """guess: the law to begin with. pulls: float64[k], of the sheet, to begin with."""
        self._fitter, self._guess = fitter, guess
        self._space = Coordinates(fitter, guess, port)
        self._point = self._space.begin(pulls)
        self.best = evaluate(fitter, *self._space.parted(self._point))
        self._gap = self.best.gap
        self._slopes = np.zeros((len(self._every), *self._gap.shape))
        self._secants: FloatArray | None = None
        self._last: Stage | None = None
        self._before, self._ended = math.inf, False

    @property
    def _every(self) -> range:
        return range(len(self._space.price))

    def through(self, stages: Sequence[tuple[Stage, int]]) -> Played:
        """The best after stages in turn, each with so many steps at the most; without bands."""
        for stage, most in stages:
            # Whatever comes of it, the linear stage says which samples tell how well it is known.
            done = self._last is not None and math.sqrt(self.best.fitted) <= self._fitter.perfect
            if done and not stage.linear:
                continue
            still = self.best.fitted > _STILL * self._before
            if stage is self._last and (self._ended if stage.linear else still):
                continue
            self._through(stage, most, fresh=self._last is None)
        return self.best

    def _through(self, stage: Stage, most: int, *, fresh: bool) -> None:
        """One stage; fresh: whether derivatives are worked out at first."""
        space, fitter = self._space, self._fitter
        self._before, self._last = self.best.fitted, stage
        passed: list[tuple[FloatArray, Played]] = []
        objective = _objective(fitter, space, stage, self._gap, passed)
        differences = space.differences(stage)
        if stage.linear:
            if self._secants is None:
                self._secants = self._slopes.copy()
            differentiate(objective, self._point, self._gap, self._slopes, self._every, differences)
            if space.mended is not None:
                space.mended(self._slopes, self._point)
            linear = linear_of(self._gap, self._slopes, self._secants, space.price, fitter)
            objective = _of_linear(objective, linear, fitter.rows)
        self._ended = descend(
            objective,
            self._point,
            self._slopes,
            self._every,
            self._every,
            differences,
            most=most,
            least=CONVERGED,
            fresh=fresh,
            mended=space.mended,
        )
        # The next stage goes on from what this one finds best, as it sees it.
        values = [objective.value(one.gap, where) for where, one in passed]
        self._point, found = passed[int(np.argmin(values))]
        self._gap = found.gap
        # All samples together may have led into a hole that spikes have dug; the others lead out.
        others = [found] if stage.linear else [self.best, *(one for _, one in passed)]
        self.best = min(others, key=lambda one: one.fitted)

    def known(self) -> Played:
        """The best with its 95 % bands, from derivatives that are exact; after `CLOSELY`."""
        assert self._secants is not None
        self._through(*_EXACTLY, fresh=True)
        space, fitter, best = self._space, self._fitter, self.best
        linear = linear_of(best.gap, self._slopes, self._secants, space.price, fitter)
        seen = self._slopes[:, :, fitter.rows].reshape(len(self._slopes), -1)
        half, pull_half = half_widths(
            best.law,
            best.gap,
            seen * linear.ravel(),
            space.along,
            space.price,
            self._guess,
            fitter,
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
