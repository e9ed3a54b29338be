"""The rate of a wave that was searched, as one more coefficient of the fit that holds the wave.

To first order another rate adds its derivative, a wave that grows along the turn or over time. The
fit tells how much of it there is, and what noise and other effects make of that, as it does for any
coefficient.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from ...arrays import FloatArray
from ...effects.term import Term
from .solution import Solution


def is_searched(term: Term) -> bool:
    """Whether it is a wave whose rate may have any value."""
    return term.rate > 0.0 and not term.whole


def resolution(term: Term) -> float:
    """Rates that are so far apart differ by a period over all of the turn or time."""
    return math.tau * term.rate / float(np.ptp(term.phase))


def by_rate(term: Term, coefficients: FloatArray) -> Term:
    """What a wave of these coefficients, float64[k], changes by its rate; sine and cosine parts
    take turns in its columns."""
    along = (term.phase - np.mean(term.phase)) / term.rate
    sines, cosines = term.columns[::2], term.columns[1::2]
    column = along * (coefficients[::2] @ cosines - coefficients[1::2] @ sines)
    return Term(
        effect=term.effect,
        key=f"{term.key} by rate",
        columns=column[None],
        parameters=lambda c: (),
        values=lambda c: {},
        low=(-math.inf,),
        rate=term.rate,
        follows=True,
        of_effort=False,
    )


def with_rates(solution: Solution) -> tuple[Solution, dict[str, int]]:
    """A solution with the rate of every wave that was searched among its coefficients, as found;
    and where, by the key of the wave."""
    waves = [one for one in solution.terms if is_searched(one)]
    if not waves:
        return solution, {}
    more = [by_rate(one, solution.of(one)) for one in waves]
    none, first = np.zeros(len(more)), solution.coefficients.size
    made = replace(
        solution,
        terms=(*solution.terms, *more),
        coefficients=np.concatenate([solution.coefficients, none]),
        prior=np.concatenate([solution.prior, none]),
    )
    return made, {one.key: first + at for at, one in enumerate(waves)}
