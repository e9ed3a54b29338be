"""The coordinates in which a law is fitted in closed loop, the sheet beside it.

A law moves along the directions in which the recording holds its values, and no further.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from scipy.linalg import eigh

from ...arrays import FloatArray
from ...drive.law import Law
from ..fit.fit import Fitter
from ..fit.newton import Differences
from ..fit.stages import Stage
from ..fit.torque_scale import TorqueScale, of_torque, take_out
from ..sheet import PULL_PRICE
from .axis import roughness
from .guess import Guess

_LEAST, _MOST = 6, 30  # directions that a law moves along, beside its own size
_FAR = 20.0  # times its RMS that a law may move


class Coordinates:
    """A point float64[m + k]: how far a law is along each of its directions, then pulls.

    Attributes:
        along: float64[m, values], the directions. price: float64[m + k], of a step of one.
        low, high: float64[m + k], bounds.
        mended: puts right what is known of derivatives; None where nothing is.
    """

    def __init__(self, fitter: Fitter, guess: Guess, port: str) -> None:
        self.guess, self.port = guess, port
        self.along, rough = directions(guess)
        lowest, highest = fitter.sheet.bounds()
        self.low = np.concatenate([np.full(len(rough), -_FAR), lowest])
        self.high = np.concatenate([np.full(len(rough), _FAR), highest])
        self.price = np.concatenate([rough, np.full(len(lowest), PULL_PRICE)])
        self.mended = without_scale(fitter, guess, port, self.along)

    def begin(self, pulls: FloatArray) -> FloatArray:
        """The law as it was regressed, with pulls float64[k] of the sheet."""
        point = np.concatenate([np.zeros(len(self.along)), pulls])
        return np.clip(point, self.low, self.high)

    def parted(self, point: FloatArray) -> tuple[Law, FloatArray]:
        """The law at a point, and the pulls."""
        count = len(self.along)
        values = self.guess.found.values + point[:count] @ self.along
        return self.guess.law(self.port, values), point[count:]

    def differences(self, stage: Stage) -> Differences:
        """How a stage takes derivatives."""
        steps = np.full(len(self.price), stage.pulled)
        steps[: len(self.along)] = stage.difference
        return Differences(steps, stage.central)


def directions(guess: Guess) -> tuple[FloatArray, FloatArray]:
    """What a law's values move along, float64[m, values], and what a step costs, float64[m].

    They span its own shape and what the data hold; each has the RMS of the law's values. A step
    costs its roughness, as in the regression: what was not visited follows what was.
    """
    values = guess.found.values
    size = max(float(np.sqrt(np.mean(values**2))), 1e-12)
    if len(values) == 1:
        return np.full((1, 1), size), np.zeros(1)
    found = [values / size]
    wanted = min(max(math.ceil(guess.found.freedom), _LEAST), _MOST)
    # Where the recording holds the values best, of all that are as smooth as they are.
    spread, smooth = guess.found.covariance, roughness(guess.axes)
    level = np.trace(smooth) / len(smooth)
    _, vectors = eigh(
        spread + 1e-9 * np.trace(spread) * np.eye(len(spread)),
        smooth + 1e-6 * level * np.eye(len(smooth)),
    )
    rest = np.linalg.pinv(spread, hermitian=True)
    ranked = sorted(
        vectors.T, key=lambda one: -float(one @ rest @ one) / float(one @ smooth @ one + 1e-12)
    )
    for one in ranked:
        left = one - sum(float(one @ other) / float(other @ other) * other for other in found)
        length = float(np.sqrt(np.mean(left**2)))
        if length > 1e-6 * float(np.sqrt(np.mean(one**2))):
            found.append(left / length)
        if len(found) > wanted:
            break
    along = size * np.array(found)
    costs, turned = eigh(along @ smooth @ along.T)  # so that each costs by itself
    return turned.T @ along, guess.found.stiff * np.maximum(costs, 0.0)


def without_scale(
    fitter: Fitter, guess: Guess, port: str, along: FloatArray
) -> Callable[[FloatArray, FloatArray], None] | None:
    """What takes out of derivatives what they hold along the scale of all torques, see
    `fit.torque_scale`; None where a motion may show it.

    A law of torque grows with it. along: float64[m, values], what the law moves along.
    """
    sheet = fitter.sheet
    scale = TorqueScale.of((), (), range(len(sheet)), sheet, fitter.replay.nominal)
    if scale is None or "torque" in guess.of:
        return None
    count, grows = len(along), of_torque(guess.law(port).unit)
    in_steps = np.linalg.pinv(along)

    def taken_out(slopes: FloatArray, point: FloatArray) -> None:
        values = guess.found.values + point[:count] @ along
        law = values @ in_steps if grows else np.zeros(count)
        moved = np.concatenate([law, scale.along(point[count:])])
        take_out(slopes, moved / np.linalg.norm(moved))

    return taken_out
