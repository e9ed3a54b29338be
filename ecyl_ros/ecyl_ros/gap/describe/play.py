"""A law played in closed loop: the recording replayed with it, its values fitted there.

A regression along the recorded motion gives the law's form; what counts is what the loop makes of
it. The law moves along the directions in which the recording holds its values, the constants of the
sheet beside it at their price.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import eigh

from ...drive.law import Law
from ..compete.earn import AT_FLOOR
from ..fit.fit import CONVERGED, Fitter
from ..fit.linear import linear_samples
from ..fit.newton import Differences, Objective, descend, differentiate
from ..fit.robust import LOSS_SCALE, cost, per_square, robust_weights
from ..fit.stages import COARSE, EXACT, FINE, LINEAR, MEDIUM, Stage
from ..fit.torque_scale import TorqueScale, of_torque, take_out
from ..inverse import inverse_of
from ..judge.intervals import FORM, quantile, spreads
from ..replay.replay import BoolArray, FloatArray
from ..sheet import PULL_PRICE
from ..split import stretch_of
from .axis import roughness
from .choose import Guess

_LEAST, _MOST = 6, 30  # directions that a law moves along, beside its own size
_FAR = 20.0  # times its RMS that a law may move
# How it is fitted: stages in turn, each with fresh derivatives and so many steps at the most.
ROUGHLY = ((COARSE, 2),)
CLOSELY = (
    *((COARSE, 3),) * 2,
    (MEDIUM, 3),
    *((LINEAR, 1),) * 4,  # which samples count is told anew after each step
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
    sheet, rows = fitter.sheet, fitter.rows
    along, rough = directions(guess)
    count, size = len(along), len(along) + len(sheet)
    mended = without_scale(fitter, guess, port, along)

    def at(point: FloatArray) -> Law:
        return guess.law(port, guess.found.values + point[:count] @ along)

    best = evaluate(fitter, guess.law(port), pulls)
    lowest, highest = sheet.bounds()
    low = np.concatenate([np.full(count, -_FAR), lowest])
    high = np.concatenate([np.full(count, _FAR), highest])
    price = np.array([*rough, *[PULL_PRICE] * len(sheet)])
    reached = np.clip(np.concatenate([np.zeros(count), pulls]), low, high)
    gap = best.gap
    slopes = np.zeros((size, *gap.shape))

    def residual(where: FloatArray) -> FloatArray:
        return fitter.replay.playing(at(where)).gap({}, sheet.constants(where[count:]))

    before = math.inf
    last: Stage | None = None
    secants: FloatArray | None = None
    ended = False
    for stage, most in how:
        # Whatever comes of it, these stages say what the law is and how well it is known.
        done = last is not None and math.sqrt(best.fitted) <= fitter.perfect
        if done and not stage.central:
            continue
        if stage is last and (ended if stage.linear else best.fitted > _STILL * before):
            continue
        first = last is None
        before, last = best.fitted, stage
        passed: list[tuple[FloatArray, Played]] = []

        def tried(
            where: FloatArray, passed: list[tuple[FloatArray, Played]] = passed
        ) -> FloatArray:
            passed.append((where, evaluate(fitter, at(where), where[count:])))
            return passed[-1][1].gap

        seen = fitter.blurred(stage.blur_s)
        objective = Objective(
            residual=residual,
            tried=tried,
            loss_scale=max(LOSS_SCALE * stage.wide, 3.0 * float(np.median(np.abs(seen(gap))))),
            evidence=sheet.evidence,
            precision=price,
            low=low,
            high=high,
            seen=seen,
        )
        steps = np.array([stage.difference] * count + [stage.pulled] * len(sheet))
        differences = Differences(steps, stage.central)
        if stage.linear:
            secants = slopes.copy() if secants is None else secants
            differentiate(objective, reached, gap, slopes, range(size), differences)
            objective = _of_linear(objective, _linear(gap, slopes, secants, price, fitter), rows)
        ended = descend(
            objective,
            reached,
            slopes,
            range(size),
            range(size),
            differences,
            most=most,
            least=CONVERGED,
            fresh=first or stage is EXACT,
            mended=mended,
        )
        # The next stage goes on from what this one finds best, as it sees it.
        values = [objective.value(one.gap, where) for where, one in passed]
        reached, found = passed[int(np.argmin(values))]
        gap = found.gap
        # All samples together may have led into a hole that spikes have dug; the others lead out.
        others = [found] if stage.linear else [best, *(one for _, one in passed)]
        best = min(others, key=lambda one: one.fitted)
    if last is not EXACT or secants is None:
        return best  # a comparison needs no bands
    linear = _linear(best.gap, slopes, secants, price, fitter).ravel()
    slopes = slopes[:, :, rows].reshape(size, -1)
    half, pull_half = _half_widths(best, slopes * linear, along, price, guess, fitter)
    unseen = _unseen(best, slopes, price, fitter)
    return dataclasses.replace(best, half=half, pull_half=pull_half, unseen=unseen)


def _linear(
    gap: FloatArray,
    tangents: FloatArray,
    secants: FloatArray,
    price: FloatArray,
    fitter: Fitter,
) -> BoolArray:
    """Which fitted samples of each signal answer linearly, see `fit.linear`."""
    weights = robust_weights(gap[:, fitter.rows])
    short, long = (one[:, :, fitter.rows].reshape(len(one), -1) for one in (tangents, secants))
    found = linear_samples(short, long, weights.ravel(), fitter.sheet.evidence, price)
    return found.reshape(weights.shape)


def _of_linear(objective: Objective, linear: BoolArray, rows: BoolArray) -> Objective:
    """The objective where these of the fitted samples count alone."""
    share = float(linear.mean())
    return dataclasses.replace(
        objective,
        seen=lambda gap: gap[:, rows][linear],
        evidence=share * objective.evidence,
    )


def _half_widths(
    best: Played,
    slopes: FloatArray,
    along: FloatArray,
    price: FloatArray,
    guess: Guess,
    fitter: Fitter,
) -> tuple[FloatArray, FloatArray]:
    """Half the widths of the 95 % bands of values and pulls.

    Along the directions that the law moved, from the replays; across them from the regression.
    """
    count, time_s = len(along), fitter.replay.time_s
    spread, stretches = spreads(slopes, best.gap, fitter.rows, time_s, fitter.sheet.evidence, price)
    moved = np.einsum("ik,sij,jk->sk", along, spread[:, :count, :count], along).max(axis=0)
    across = np.eye(along.shape[1]) - np.linalg.pinv(along) @ along
    stayed = np.einsum("ki,ij,kj->k", across, guess.found.covariance, across)
    variance = np.maximum(moved, 0.0) + np.maximum(stayed, 0.0)
    own = np.maximum(np.diagonal(spread, axis1=1, axis2=2).max(axis=0)[count:], 0.0)
    half = np.hypot(quantile(stretches) * np.sqrt(variance), FORM * np.abs(best.law.values))
    return half, 1.96 * np.sqrt(own)


def _unseen(best: Played, slopes: FloatArray, price: FloatArray, fitter: Fitter) -> FloatArray:
    """The gap on each fitted stretch as the others alone would leave it, beside the held-out ones.

    Without a stretch the fit moves by a Newton step from where it is.
    """
    rows = fitter.rows
    stretch = stretch_of(fitter.replay.time_s[rows])
    gap = best.gap[:, rows]
    shape = (len(slopes), *gap.shape)
    weight = robust_weights(gap)
    pieces = per_square(fitter.sheet.evidence, weight, gap)
    found = gap.copy()
    parts = []
    for one in np.unique(stretch):
        chosen = stretch == one
        slope = slopes.reshape(shape)[:, :, chosen].reshape(len(slopes), -1)
        pushed = slope * weight[:, chosen].ravel()
        parts.append((chosen, slope, pushed @ slope.T, pushed @ gap[:, chosen].ravel()))
    whole = sum(part[2] for part in parts)
    for chosen, slope, own, force in parts:
        step = inverse_of(pieces * (whole - own) + np.diag(price)) @ (pieces * force)
        found[:, chosen] += (step @ slope).reshape(len(gap), -1)
    unseen = best.gap.copy()
    unseen[:, rows] = found
    return unseen


def at_noise(fitter: Fitter, cost: float) -> bool:
    """Whether a cost is no more than a perfect model's."""
    return math.sqrt(cost) <= AT_FLOOR * fitter.perfect
