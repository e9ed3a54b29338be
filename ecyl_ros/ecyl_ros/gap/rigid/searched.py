"""Parameters that were searched, as further coefficients of the fit that holds their term.

To first order another rate of a wave, another Stribeck speed, another place adds the derivative of
what the term explains. A fit tells how much of that there is, and what noise and other effects make
of it, as it does for any coefficient.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from ...arrays import FloatArray
from ...effects.term import Term
from .solution import Solution

_STEP = 1e-3  # of the reach, for a derivative


def slopes(term: Term, coefficients: FloatArray) -> dict[str, Term]:
    """What a term of these coefficients, float64[k], changes by each parameter that was searched,
    by its name."""
    found = {}
    for name, reach in term.reach.items():
        step = _STEP * reach
        columns = [
            term.moved({**term.fixed, name: term.fixed[name] + way * step}).columns
            for way in (1.0, -1.0)
        ]
        found[name] = Term(
            effect=term.effect,
            key=f"{term.key} by {name}",
            columns=(coefficients @ (columns[0] - columns[1]) / (2.0 * step))[None],
            parameters=lambda c: (),
            values=lambda c: {},
            low=(-math.inf,),
            rate=term.rate,
            follows=True,
            of_effort=False,
        )
    return found


def with_searched(solution: Solution) -> tuple[Solution, dict[tuple[str, str], int]]:
    """A solution with every parameter that was searched among its coefficients, as found; and
    where, by the key of the term and its name."""
    more, places = list[Term](), {}
    for one in solution.terms:
        for name, slope in slopes(one, solution.of(one)).items():
            places[one.key, name] = solution.coefficients.size + len(more)
            more.append(slope)
    if not more:
        return solution, places
    none = np.zeros(len(more))
    made = replace(
        solution,
        terms=(*solution.terms, *more),
        coefficients=np.concatenate([solution.coefficients, none]),
        prior=np.concatenate([solution.prior, none]),
    )
    return made, places
