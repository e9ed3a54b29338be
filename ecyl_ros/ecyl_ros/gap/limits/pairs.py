"""Which effects a recording hardly tells apart, and by how many noise floors."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ...arrays import FloatArray
from ...effects.catalogue import CATALOGUE
from ..judge.verdict import INDISTINCT
from .columns import Base
from .limit import Alike
from .loss import rise, weights
from .seen import Seen

_ROUNDS = 4
_THIN = 4  # rows from one that is glimpsed at to the next
_NEAR = 2.0  # times what is needed: so near a pair is looked at closely
TIMES = 3.0  # as large as the smallest that is seen: a fault that shows, not one that can be sized


def separation(base: Base, acting: FloatArray, other: FloatArray) -> float:
    """What the sheet and another effect of any size leave of a response, in noise floors.

    By how much the mean square with the other effect in place stands above that of the model as it
    is, as the competition counts it: with the robust loss, and the price of the sheet.

    acting: float64[m], in floors. other: float64[0 to 2, m].
    """
    rows = np.concatenate([base.free, other])
    prior = np.concatenate([base.precision, np.zeros(len(other))])
    evidence = base.fitter.sheet.evidence
    level = base.fit.left
    left, cost = acting, level
    least = math.inf
    for _ in range(_ROUNDS):  # what is left decides how much a spike, and the price, counts
        weighed = rows * (evidence / cost / acting.size * weights(left))
        found = _solved(weighed @ rows.T + np.diag(prior), weighed @ acting)
        left = acting - found @ rows
        cost = level + max(float(np.mean(rise(left))), 0.0)
        least = min(least, cost * math.exp(min(float(prior @ found**2) / evidence, 100.0)))
    return math.sqrt(max(least - level, 0.0))


def _solved(gram: FloatArray, aim: FloatArray) -> FloatArray:
    size = np.sqrt(np.maximum(np.diag(gram), 1e-300))
    found: FloatArray = (
        np.linalg.lstsq(gram / np.outer(size, size), aim / size, rcond=1e-10)[0] / size
    )
    return found


def needed(base: Base) -> float:
    """The separation from which two sets are told apart, see `verdict.alternatives`."""
    perfect = base.fitter.perfect_with(base.fit.values)
    return math.sqrt(INDISTINCT) * perfect


def alike(base: Base, seen: Sequence[Seen]) -> tuple[Alike, ...]:
    """Pairs that are not told apart at `TIMES` the smallest size that is seen, closest first."""
    shown = [one for one in seen if math.isfinite(one.size)]
    least = needed(base)
    found = []
    for one in shown:
        acting = TIMES * one.response[0]
        near = _glimpsed(base, acting, [other.response for other in shown])
        for other, apart in zip(shown, near, strict=True):
            names = (one.probe.effect, other.probe.effect)
            if one is other or apart > _NEAR * least or _nested(*names):
                continue
            apart = separation(base, acting, other.response)
            if apart < least:
                found.append(Alike(names, apart, least, TIMES))
    return tuple(sorted(found, key=lambda pair: pair.separation))


def _glimpsed(base: Base, acting: FloatArray, others: Sequence[FloatArray]) -> list[float]:
    """`separation` from each of others by one weighing of all: tells which are close."""
    some = slice(None, None, _THIN)
    rows = np.concatenate([base.free, *others, acting[None]])[:, some]
    weighed = rows * weights(acting[some])
    gram = weighed @ rows.T / rows.shape[1]
    prior = np.zeros(len(rows))
    prior[: len(base.precision)] = base.precision * base.fit.left / base.fitter.sheet.evidence
    found, at = [], len(base.free)
    for one in others:
        using = [*range(len(base.free)), *range(at, at + len(one))]
        at += len(one)
        part = gram[np.ix_(using, using)] + np.diag(prior[using])
        aim = gram[using, -1]
        left = gram[-1, -1] - _solved(part, aim) @ aim  # its price included
        found.append(math.sqrt(max(float(left), 0.0)))
    return found


def _nested(first: str, second: str) -> bool:
    """Whether one holds the other as a special case."""
    return first in CATALOGUE[second].refines or second in CATALOGUE[first].refines
