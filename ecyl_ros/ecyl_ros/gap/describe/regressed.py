"""A law that one regression finds, in a balance along a measured motion that needs no replay."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...drive.law import Law
from ..diagnosis import FloatArray
from .chance import probability
from .choose import Balance, Choice
from .description import Course, Description
from .formula import formula
from .missing import Missing


def larger_than_its_band(looked: Balance, choice: Choice) -> bool:
    """Whether the law is larger than its 95 % band where it was visited.

    What the file leaves out, and the law, may be exchanged for one another at any size.
    """
    found = choice.best.found
    seen = looked.seen(choice.best)
    variance = np.maximum(np.diag(found.covariance), 0.0)[seen]
    return bool(np.mean(found.values[seen] ** 2) > 1.96**2 * np.mean(variance))


def by_chance(choice: Choice) -> float:
    """The probability of as good a prediction by a law without connection to what is missing."""
    used = choice.alone.count > 0
    before, after = choice.alone.errors[used], choice.best.found.errors[used]
    sets = {(one.kind, one.of) for one in (choice.best, *choice.rivals)}
    return probability(before, after, len(sets))


def parts(looked: Balance, choice: Choice, missing: Missing) -> tuple[FloatArray, FloatArray]:
    """What law and sheet give along the motion, float64[n] each, positive where it drives."""
    best = choice.best
    table = best.found.values @ looked.table(best)
    if best.kind == "friction":
        table = -np.sign(looked.motion.speed) * table
    return table, best.found.pulls @ missing.columns


def sheet_alone(choice: Choice, missing: Missing) -> FloatArray:
    """What the sheet alone gives along the motion, float64[n]."""
    found: FloatArray = choice.alone.pulls @ missing.columns
    return found


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
        chance=by_chance(choice),
        next_best=tuple((one.of, one.found.error / best.found.error) for one in rivals[:3]),
        ports=(),
        turns={},
        resembles=None,
        course=course,
        points=np.array([*along, values]),
        in_balance=True,
    )
