"""The limits of a rigid drive's recording: from the columns that its effects competed with.

An effect is seen where it earns its place by what the competition asks (`sets.Gain`): a good part
of what stands above the floor, and more than the stretches differ among themselves, on fitted and
on held-out ones; and where the model without it no longer stands at the floor (`judge`). What the
sheet's constants and the named effects can do in its place is taken out first, at its price.

That holds as far as nothing else keeps an effect from being named. One that the recording shows at
least as large, and that is not named all the same, has no limit.
"""

from __future__ import annotations

import math
from collections.abc import Collection
from typing import TYPE_CHECKING

import numpy as np

from ...arrays import BoolArray, FloatArray
from ...effects.catalogue import RIGID
from ...effects.term import Term
from ..compete.strain import STRAINED
from ..replay.hidden import NO_GAP_RATIO
from ..rigid.balance import Balance
from ..rigid.sets import HELD_SURE, LEAST_GAIN, SURE, Sets
from ..rigid.solution import Solution
from ..rigid.uncertainty import intervals, unmodelled
from .limit import Limit
from .possible import possible

if TYPE_CHECKING:
    from ..rigid.judge import Judgement

_ONE_SIDED = 1.645  # standard errors: seen with 95 %
_DIRECTIONS = 8  # phases of a sine that are looked at
_BISECTIONS = 40
_OUT = math.sqrt(STRAINED / 4.0)  # tolerances from which a constant counts as strained


def rigid_limits(judgement: Judgement, without: Collection[str] = ()) -> tuple[Limit, ...]:
    """What the recording would have shown beside the set that was judged; an effect that it shows
    and that is not named for all that is left out.

    without: effects that did not compete.
    """
    sets = Sets(judgement.null, judgement.floor, without)
    order = list(judgement.contest.order)
    current = judgement.null.fit(order)
    named = {one.effect for one in order} | {name for one in order for name in one.refines}
    first: dict[str, Term] = {}
    for term in sets.candidates(current, order):
        first.setdefault(term.effect, term)
    found = []
    for term in first.values():
        if term.effect not in named:
            limit = _limit(judgement, current, term)
            if limit is not None and not _there(judgement, term, limit):
                found.append(possible(limit))
    return tuple(found)


def _there(judgement: Judgement, term: Term, limit: Limit) -> bool:
    """Whether the recording shows the effect, by its interval, at least as large as its limit."""
    if limit.smallest_seen is None:
        return False
    balance = judgement.balance
    fit = judgement.null.fit([*judgement.contest.order, term], balance.usable)
    span = intervals(balance, fit, balance.usable)[term.key][0]
    shows = not span.low <= limit.neutral <= span.high
    return shows and abs(span.value - limit.neutral) >= limit.smallest_seen


def _limit(judgement: Judgement, current: Solution, term: Term) -> Limit | None:
    """Of one effect; None where it has no size of its own, or one in each recording."""
    if term.common is not None:
        return None
    balance = judgement.balance
    columns = balance.columns([term])
    beside = [one for one in current.terms if one.effect != term.effect]
    prior = _prior(current, beside)
    fitted, judged = balance.fitted, balance.judged
    basis = balance.columns(beside)
    sines = columns.shape[1] == 2 and term.rate != 0.0
    weights = current.weights[fitted]
    wanted = columns if sines else columns[:, :1]
    if basis.shape[1]:
        held = basis[fitted] * weights[:, None]
        gram = held.T @ basis[fitted] + np.diag(prior**2 * current.share)
        size = np.sqrt(np.maximum(np.diag(gram), 1e-300))
        solved = np.linalg.lstsq(
            gram / np.outer(size, size), held.T @ wanted[fitted] / size[:, None], rcond=1e-10
        )[0]
        wanted = wanted - basis @ (solved / size[:, None])
    ways: list[tuple[float, ...]] = [(1.0,)]
    if sines:
        turns = math.pi * np.arange(_DIRECTIONS) / _DIRECTIONS
        ways = [(math.cos(one), math.sin(one)) for one in turns]
    worst, way = 0.0, ways[0]
    for one in ways:
        response = wanted @ np.array(one)
        beyond = unmodelled(balance, wave=term.rate != 0.0)
        smallest = _smallest(judgement, current, response, (fitted, judged), beyond)
        if smallest > worst:
            worst, way = smallest, one
    own = next((one for one in judgement.null.uncertain if one.term.effect == term.effect), None)
    if own is not None and RIGID[term.effect].constant[not judgement.machine.linear]:
        worst = max(worst, _OUT * own.width)
    asked = ((columns if sines else columns[:, :1]) @ np.array(way))[balance.usable]
    varies = worst * float(np.std(asked)) > judgement.spread
    if varies or worst * _rms(asked) > _rms(balance.effort[balance.usable]):
        worst = math.inf  # as large as all that was recorded: no size to speak of
    return _told(term, worst, way, columns.shape[1])


def _smallest(
    judgement: Judgement,
    current: Solution,
    response: FloatArray,
    rows: tuple[BoolArray, BoolArray],
    unmodelled: float,
) -> float:
    """Multiple of a response, float64[m], that is seen with 95 %; inf where none is.

    unmodelled: RMS of what no model explains, that its interval holds and it has to exceed.
    """
    balance, floor = judgement.balance, judgement.floor
    both = [
        _Stretches(balance, current.residual, response, on, least, sure, floor)
        for on, least, sure in zip(
            rows, (LEAST_GAIN, 0.5 * LEAST_GAIN), (SURE, HELD_SURE), strict=True
        )
        if on.any()
    ]
    power = float(np.mean(response[balance.usable] ** 2))
    if not power > 0.0:
        return math.inf
    unit = floor / math.sqrt(power)
    low, high = 1e-3, 1e4
    if not all(one.seen(high * unit) for one in both):
        return math.inf
    for _ in range(_BISECTIONS):
        middle = math.sqrt(low * high)
        seen = all(one.seen(middle * unit) for one in both)
        low, high = (low, middle) if seen else (middle, high)
    return high * unit + unmodelled / math.sqrt(power)


class _Stretches:
    """What a response of any size adds to the squared residual of each stretch."""

    def __init__(
        self,
        balance: Balance,
        residual: FloatArray,
        response: FloatArray,
        rows: BoolArray,
        least: float,
        sure: float,
        floor: float,
    ) -> None:
        own = balance.by_stretch(response**2, rows)
        across = 2.0 * balance.by_stretch(residual * response, rows)
        self._left = float(np.mean(balance.by_stretch(residual**2, rows)))
        self._least, self._sure, self._floor = least, sure, floor
        self._count, self._own = own.size, float(np.mean(own))
        # Of what a size of 1 adds by its square and by itself; one stretch has no variance.
        several = own.size > 1
        self._covariance = np.cov(own, across) if several else np.zeros((2, 2))

    def seen(self, size: float) -> bool:
        """Whether it earns its place, with 95 %."""
        if self._count < 3:
            return False
        (own, both), (_, across) = self._covariance.tolist()
        variance = size**4 * own + 2.0 * size**3 * both + size**2 * across
        error = math.sqrt(max(variance, 0.0) / self._count)
        # By chance, noise stands with the effect or against it.
        by_chance = size * math.sqrt(across / self._count)
        sure = size**2 * self._own - _ONE_SIDED * by_chance
        before = self._left + sure
        surplus = max(before - self._floor**2, 0.5 * before, 1e-300)
        return (
            before > (NO_GAP_RATIO * self._floor) ** 2
            and sure >= self._least * surplus
            and sure >= self._sure * error
        )


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _prior(current: Solution, beside: list[Term]) -> FloatArray:
    """Of the terms of a solution that are kept, float64[k]."""
    made, at = [], 0
    for one in current.terms:
        size = one.columns.shape[0]
        if any(one is other for other in beside):
            made.append(current.prior[at : at + size])
        at += size
    return np.concatenate(made) if made else np.zeros(0)


def _told(term: Term, size: float, way: tuple[float, ...], count: int) -> Limit | None:
    """In the effect's own parameter."""
    coefficients = np.zeros(count)
    none = term.parameters(coefficients)
    if not none:
        return None
    name, unit, neutral = none[0]
    at = {key: value for key, _, value in none[1:] if key in term.fixed}
    if not math.isfinite(neutral):
        neutral = 0.0
    if not math.isfinite(size):
        return Limit(term.effect, name, unit, None, neutral, 1, at)
    coefficients[: len(way)] = np.array(way) * size
    value = term.parameters(coefficients)[0][2]
    if term.phase.size and neutral:  # what comes on top, in whatever phase
        value = neutral + float(np.linalg.norm(coefficients))
    if not math.isfinite(value):
        return None
    return Limit(term.effect, name, unit, abs(value - neutral), neutral, 1, at)
