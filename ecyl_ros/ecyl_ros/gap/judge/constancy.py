"""Whether a cause has one size all through the recording, as a true one has.

Where structure is left, the best effect may stand for something of another form: a backlash for a
worn place, a viscous friction for a drag that grows with the square of speed, a resistance for a
winding that warms up. Such a stand-in needs one size here and another there. Each effect is
therefore tried in other sizes, and judged on parts of the recording by themselves: if what is left
falls clearly once every part may choose its own size, the effect is not what it is named after.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace

import numpy as np

from ...arrays import BoolArray, FloatArray
from ...effects.catalogue import CATALOGUE
from ..compete.competition import Competition, leave_one_out
from ..compete.earn import earns
from ..fit.descent import polish
from ..fit.fit import Fit, Fitter
from ..fit.robust import cost, misfit, robust_squares
from ..replay.evidence import Smoother, gather
from ..replay.replay import Replay

_SIZES = (0.5, 0.7, 0.8, 0.9, 0.95, 1.0, 1.05, 1.1, 1.2, 1.4, 2.0)
_MOVING = 0.02  # of the top speed
_STRUCTURE = 1.15  # times a perfect model's misfit: closer than this nothing is left to tell from
_STAND_IN = 0.08  # gain from which an effect counts as a stand-in; true causes show under 0.02
_STEPS = 4
_DRAWS, _SURE = 6, 2.0  # of noise in the loop; standard deviations from draw to draw


@dataclass(frozen=True)
class Inconstancy:
    """What an effect would gain by having another size in every part of the recording.

    Attributes:
        effect: its name.
        condition: what the parts differ in.
        sizes: that suit the parts best, over the fitted size; parts in rising order.
        gain: share of what is left over a perfect model that this would remove.
    """

    effect: str
    condition: str
    sizes: tuple[float, ...]
    gain: float


def conditions(replay: Replay) -> Iterator[tuple[str, tuple[BoolArray, ...]]]:
    """Parts of the recording by time, speed, direction, position and torque: (name, masks)."""
    evidence = gather(replay, {})
    smooth = Smoother(replay.time_s)
    speed = smooth(evidence.rotor_speed_rad_s)
    everywhere = replay.usable
    moving = everywhere & (np.abs(speed) > _MOVING * float(np.abs(speed).max()))
    yield "time", _parts(replay.time_s, everywhere, 4)
    yield "speed", _parts(np.abs(speed), moving, 3)
    yield "direction", (moving & (speed < 0.0), moving & (speed > 0.0))
    yield "position", _parts(replay.reference_m, everywhere, 4)
    if np.isfinite(evidence.current_a).all():
        yield "torque", _parts(np.abs(smooth(evidence.current_a)), everywhere, 3)


def _parts(values: FloatArray, among: BoolArray, count: int) -> tuple[BoolArray, ...]:
    """Masks of `count` parts of `among` with equally many samples, by rising value."""
    if not among.any():
        return ()
    edges = np.quantile(values[among], np.linspace(0.0, 1.0, count + 1)[1:-1])
    part = np.searchsorted(edges, values)
    return tuple(among & (part == index) for index in range(count))


def inconstancies(fit: Fit, fitter: Fitter) -> list[Inconstancy]:
    """For each effect of a fit the condition that its size changes most with, worst first."""
    replay = fitter.replay
    usable = replay.usable
    surplus = float(robust_squares(fit.gap[:, usable]).mean()) - fitter.sound_with(fit) ** 2
    if surplus <= 0.0:
        return []
    surplus = max(surplus, by_chance(fit, fitter))
    parts = list(conditions(replay))

    def resized(name: str, size: float) -> Fit:
        if size == 1.0:
            return fit
        values = CATALOGUE[name].scaled(fit.values[name], size, replay.drive)
        return fitter.evaluate({**fit.values, name: values}, fit.pulls)

    found = []
    for name in fit.names:
        costs = np.array([robust_squares(resized(name, size).gap).mean(axis=0) for size in _SIZES])
        tried = []
        for condition, masks in parts:
            each = np.array([costs[:, mask].sum(axis=1) for mask in masks])
            if not each.size:
                continue
            gain = float(each.sum(axis=0).min() - each.min(axis=1).sum()) / usable.sum() / surplus
            sizes = tuple(_SIZES[index] for index in np.argmin(each, axis=1))
            tried.append(Inconstancy(name, condition, sizes, gain))
        found.append(max(tried, key=lambda one: one.gain))
    return sorted(found, key=lambda one: -one.gain)


def by_chance(fit: Fit, fitter: Fitter) -> float:
    """What may be left over a perfect model by chance, in robust mean squares of noise floors.

    Noise that a loop amplifies drifts as slowly as the loop follows, and is more in one draw than
    in the next.
    """
    replay = fitter.replay
    if not (replay.noise_in_loop and fitter.amplified):
        return 0.0
    draws = [replay.healthy_with(fit.values, draw) for draw in range(_DRAWS)]
    return _SURE * float(np.std([cost(one, replay.usable) for one in draws], ddof=1))


def without_stand_ins(
    competition: Competition, fitter: Fitter
) -> tuple[Competition, tuple[Inconstancy, ...]]:
    """The competition with stand-ins taken out of its winner, and what gave them away."""
    winner = competition.winner
    if not winner.names or misfit(winner.judged) <= _STRUCTURE * fitter.sound_with(winner):
        return competition, ()
    odd = tuple(one for one in inconstancies(winner, fitter) if one.gain > _STAND_IN)
    if not odd:
        return competition, ()
    return without_effects(competition, fitter, [one.effect for one in odd]), odd


def without_effects(
    competition: Competition, fitter: Fitter, effects: Collection[str]
) -> Competition:
    """The competition with `effects` taken out of its winner, the others fitted again."""
    winner = competition.winner
    best = competition.sheet
    if set(winner.names) - set(effects):
        start = fitter.without(winner, effects)
        fit = polish(fitter, start, _STEPS)
        best = fit if earns(fitter, fit, best) else best
    without = leave_one_out(
        fitter, best, competition.sheet, lambda start: polish(fitter, start, _STEPS)
    )
    rivals = tuple(one for one in competition.singles if one.names != best.names)
    return replace(competition, winner=best, rivals=rivals, leave_one_out=without)
