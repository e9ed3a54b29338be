"""Which effects a recording hardly tells apart, and by how many noise floors."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...effects.catalogue import CATALOGUE
from ..replay import FloatArray
from ..verdict import INDISTINCT
from .columns import Base
from .limit import Alike
from .loss import rise, weights

if TYPE_CHECKING:
    from .cylinder import Seen

_ROUNDS = 2
_THIN = 4  # rows from one that is glimpsed at to the next
_NEAR = 2.0  # times what is needed: so near a pair is looked at closely
TIMES = 3.0  # as large as the smallest that is seen: a fault that shows, not one that can be sized


def left_of(base: Base, acting: FloatArray, other: FloatArray, cost: float) -> FloatArray:
    """What the sheet and another effect of any size leave of a response, float64[m].

    Args:
        acting: float64[m], in floors. other: float64[0 to 2, m].
        cost: mean square beside which the sheet's price is weighed.
    """
    rows = np.concatenate([base.free, other])
    prior = np.concatenate([base.precision, np.zeros(len(other))])
    scale = base.fitter.sheet.evidence / cost / acting.size
    left = acting
    for _ in range(_ROUNDS):  # what is left decides how much a spike counts
        weighed = rows * (scale * weights(left))
        left = acting - _solved(weighed @ rows.T + np.diag(prior), weighed @ acting) @ rows
    return left


def _solved(gram: FloatArray, aim: FloatArray) -> FloatArray:
    size = np.sqrt(np.maximum(np.diag(gram), 1e-300))
    found: FloatArray = (
        np.linalg.lstsq(gram / np.outer(size, size), aim / size, rcond=1e-10)[0] / size
    )
    return found


def separation(left: FloatArray) -> float:
    """RMS that a difference adds to noise, in floors, as the robust loss counts it."""
    return math.sqrt(max(float(np.mean(rise(left))), 0.0))


def needed(base: Base) -> float:
    """The separation from which two sets are told apart, see `verdict.alternatives`."""
    perfect = base.fitter.perfect_with(base.fit.values)
    return math.sqrt(INDISTINCT) * perfect


def alike(base: Base, seen: Sequence[Seen]) -> tuple[Alike, ...]:
    """Pairs that are not told apart at `TIMES` the smallest size that is seen, closest first."""
    shown = [one for one in seen if math.isfinite(one.size)]
    cost = base.fit.left
    least = needed(base)
    found = []
    for one in shown:
        acting = TIMES * one.response[0]
        near = _glimpsed(base, acting, [other.response for other in shown], cost)
        for other, apart in zip(shown, near, strict=True):
            names = (one.probe.effect, other.probe.effect)
            if one is other or apart > _NEAR * least or _nested(*names):
                continue
            apart = separation(left_of(base, acting, other.response, cost))
            if apart < least:
                found.append(Alike(names, apart, least, TIMES))
    return tuple(sorted(found, key=lambda pair: pair.separation))


def _glimpsed(
    base: Base, acting: FloatArray, others: Sequence[FloatArray], cost: float
) -> list[float]:
    """`separation` from each of others by one weighing of all: tells which are close."""
    some = slice(None, None, _THIN)
    rows = np.concatenate([base.free, *others, acting[None]])[:, some]
    weighed = rows * weights(left_of(base, acting, np.zeros((0, acting.size)), cost)[some])
    gram = weighed @ rows.T / rows.shape[1]
    prior = np.zeros(len(rows))
    prior[: len(base.precision)] = base.precision * cost / base.fitter.sheet.evidence
    found, at = [], len(base.free)
    for one in others:
        using = [*range(len(base.free)), *range(at, at + len(one))]
        at += len(one)
        part = gram[np.ix_(using, using)] + np.diag(prior[using])
        size = _solved(part, gram[using, -1])
        plain = gram[np.ix_(using, using)]
        left = gram[-1, -1] - 2.0 * size @ gram[using, -1] + size @ plain @ size
        found.append(math.sqrt(max(float(left), 0.0)))
    return found


def _nested(first: str, second: str) -> bool:
    """Whether one holds the other as a special case."""
    return first in CATALOGUE[second].refines or second in CATALOGUE[first].refines
