"""What the pulls of a set on the data sheet say against it, beside other sets.

A fit counts every pull as it stands. Between two sets that fit alike less is known: structure that
is left bends a constant as well, and frictions that are off together tell no more than one, for
temperature moves both (Bittencourt et al., "An extended friction model to capture load and
temperature effects in robot joints", 2010).
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Collection, Iterator

import numpy as np
from scipy.optimize import brentq

from ...arrays import FloatArray
from ..judge.verdict import RARER
from .null import Null
from .solution import Solution

_FRICTION = "_friction"  # how the names of both end
_AT_FAULT = -2.0 * math.log(RARER)  # the price of a step of rarity
_ALONG = 1e-9  # of their power: columns that hold less of their own are along others


def price(
    null: Null, solution: Solution, structure: float, finer_forms: Collection[str] = ()
) -> float:
    """Twice the logarithm of the odds of the constants that a set asks for.

    structure: RMS of what is left and may be along one effect, so that it bends constants.
    finer_forms: effects whose own share of a constant counts like that constant: friction by
    direction has a level, and so pulls on that of the sheet. As it is at fault already, this costs
    a step of rarity at the most, however far off it is.
    """
    prices: defaultdict[str, float] = defaultdict(float)
    for name, found in (*_own(null, solution, structure), *_finer(null, solution, finer_forms)):
        prices[name] += found
    rubs = [one for name, one in prices.items() if name.endswith(_FRICTION)]
    return sum(prices.values()) - sum(rubs) + max(rubs, default=0.0)


def _own(null: Null, solution: Solution, structure: float) -> Iterator[tuple[str, float]]:
    """Prices of the constants that were fitted, by the effect of each."""
    if not np.any(solution.prior):
        return
    names = [one.effect for one in solution.terms for _ in range(one.columns.shape[0])]
    power = null.balance.power(solution, null.balance.usable)
    least = cheapest(solution.prior * solution.coefficients, solution.prior, power, structure)
    yield from zip(names, (least**2).tolist(), strict=True)


def cheapest(
    pulls: FloatArray, prior: FloatArray, power: FloatArray, structure: float
) -> FloatArray:
    """The cheapest pulls whose effort is off by no more than an RMS of `structure`, float64[k].

    What nothing is known of adapts. One structure bends all constants at once: it cannot be spent
    on each of them.

    power: float64[k, k], mean products of the columns.
    """
    found = np.zeros(pulls.size)
    priced = prior > 0.0
    counted = power[np.ix_(priced, priced)]
    if not priced.all():
        free, across = power[np.ix_(~priced, ~priced)], power[np.ix_(~priced, priced)]
        counted = counted - across.T @ np.linalg.pinv(free, rcond=_ALONG, hermitian=True) @ across
    per_pull = counted / np.outer(prior[priced], prior[priced])
    powers, ways = np.linalg.eigh(per_pull)
    powers = np.maximum(powers, 0.0)
    along = ways.T @ pulls[priced]

    def off(times: float) -> float:
        """By how much more than allowed, of what is as cheap as `times` the effort is near."""
        return float(np.sum(powers * (along / (1.0 + times * powers)) ** 2)) - structure**2

    if off(0.0) <= 0.0:
        return found
    high = 1.0
    while off(high) > 0.0:
        high *= 4.0
        if not math.isfinite(high):
            found[priced] = pulls[priced]
            return found
    times = brentq(off, 0.0, high)
    found[priced] = ways @ (along * times * powers / (1.0 + times * powers))
    return found


def _finer(
    null: Null, solution: Solution, finer_forms: Collection[str]
) -> Iterator[tuple[str, float]]:
    """Prices of the constants that finer forms stand for, by the effect of each."""
    finer = [one for one in solution.free if one.effect in finer_forms]
    refined = {name for one in finer for name in one.refines}
    stood_for = [one for one in null.uncertain if one.term.effect in refined]
    if not stood_for:
        return
    balance, rows = null.balance, null.balance.usable
    asked = sum(balance.columns([one])[rows] @ solution.of(one) for one in finer)
    columns = balance.columns([one.term for one in stood_for])[rows]
    size = np.sqrt(np.mean(columns**2, axis=0)) + 1e-300
    found = np.linalg.lstsq(columns / size, asked, rcond=None)[0] / size
    parts = [one for one in stood_for for _ in range(one.term.columns.shape[0])]
    widths = np.array([one.width for one in parts]) * null.gained(solution)
    names = [one.term.effect for one in parts]
    prices = np.minimum((2.0 * found / widths) ** 2, _AT_FAULT)
    yield from zip(names, prices.tolist(), strict=True)
