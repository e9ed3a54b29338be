"""A law that one regression finds, in a balance along a measured motion that needs no replay."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...arrays import BoolArray, FloatArray
from ...drive.law import Law
from ..judge.verdict import EXPLAINED_SHRINK, STRUCTURELESS, shrink_of
from .balance import Balance
from .chance import LEVEL
from .choose import Choice
from .description import Course, Description
from .formula import formula
from .missing import Missing

FREE = 1e3  # times what is missing: what a pull of a constant that nobody states may come to
LEAST_STRETCHES = 12  # that are fitted: fewer tell too little of what a law depends on


class Held(NamedTuple):
    """A law that holds: what it and the sheet give along the motion, float64[n], positive where it
    drives; the RMS that they leave on held-out samples, the share that is gone of what is above
    the floor there, and whether that accounts for all that is missing."""

    law: FloatArray
    sheet: FloatArray
    left: float
    share: float
    whole: bool


def held(
    looked: Balance, choice: Choice, missing: Missing, judged: BoolArray, floor: float
) -> Held | None:
    """The best law, where it predicts what is missing, and not by chance; None elsewhere.

    judged: bool[n], held-out samples, one at least.
    """
    best = choice.best
    if not choice.explains or not _larger_than_its_band(looked, choice):
        return None
    if _by_chance(choice) > LEVEL:
        return None
    law = best.found.values @ looked.passed(best)
    sheet = best.found.pulls @ missing.columns
    alone = missing.values - choice.alone.pulls @ missing.columns
    beside = missing.values - law - sheet
    before, left = (float(np.sqrt(np.mean(one[judged] ** 2))) for one in (alone, beside))
    share = shrink_of(before, left, max(before - floor, 1e-12))
    # Nothing says what else may act beside a law: it has to account for all, as causes do.
    return Held(law, sheet, left, share, left <= STRUCTURELESS * floor or share >= EXPLAINED_SHRINK)


def _larger_than_its_band(looked: Balance, choice: Choice) -> bool:
    """Whether the law is larger than its 95 % band where it was visited.

    What the file leaves out, and the law, may be exchanged for one another at any size.
    """
    found = choice.best.found
    seen = looked.seen(choice.best)
    variance = np.maximum(np.diag(found.covariance), 0.0)[seen]
    return bool(np.mean(found.values[seen] ** 2) > 1.96**2 * np.mean(variance))


def _by_chance(choice: Choice) -> float:
    """See `Choice.by_chance`: of the best law, over all that were tried."""
    return choice.by_chance(choice.best, choice.sets + choice.best.looked_at)


def described(
    looked: Balance,
    choice: Choice,
    law: Law,
    text: str,
    course: Course,
    values: FloatArray,
    rows: NDArray[np.int64],
) -> Description:
    """The best law as a description that nothing is said to resemble yet, its shrink unknown.

    law: with its port and units. text: its words. values: float64[m], what is missing at the port
    on `rows`.
    """
    best, motion = choice.best, looked.motion
    half = 1.96 * np.sqrt(np.maximum(np.diag(best.found.covariance), 0.0))
    along = [motion.variable(one, False, best.time_constant_s)[rows] for one in best.of]
    rivals = choice.beside(best)
    return Description(
        law=law,
        half=half,
        seen=looked.seen(best),
        shrink=0.0,
        formula=formula(law, half),
        words=text,
        chance=_by_chance(choice),
        next_best=tuple((one.of, one.found.error / best.found.error) for one in rivals[:3]),
        ports=(),
        turns={},
        resembles=None,
        course=course,
        points=np.array([*along, values]),
        in_balance=True,
    )
