"""What the pulls of a set on the data sheet say against it, beside other sets.

A fit counts every pull as it stands. Between two sets that fit alike less is known: structure that
is left bends a constant as well, and frictions that are off together tell no more than one, for
temperature moves both (Bittencourt et al., "An extended friction model to capture load and
temperature effects in robot joints", 2010).
"""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from ...effects.term import Term
from ..diagnosis import FloatArray
from .null import Null
from .solution import Solution

_FRICTION = "_friction"  # how the names of both end


class Pulls:
    """Prices of sets beside one null.

    structure: RMS of what is left and may be along one effect, so that it bends constants.
    """

    def __init__(self, null: Null, structure: float) -> None:
        self._null, self._structure = null, structure
        self._found: dict[tuple[int, frozenset[str]], tuple[Solution, float]] = {}

    def price(self, solution: Solution, finer_forms: Collection[str] = ()) -> float:
        """Twice the logarithm of the odds of the constants that a set asks for.

        finer_forms: effects whose own share of a constant counts like that constant: friction by
        direction has a level, and so pulls on that of the sheet.
        """
        key = id(solution), frozenset(finer_forms)
        if key not in self._found:  # the solution is kept, so that no other has its number
            self._found[key] = solution, self._price(solution, finer_forms)
        return self._found[key][1]

    def _price(self, solution: Solution, finer_forms: Collection[str]) -> float:
        if not np.any(solution.prior):
            return 0.0
        bent = self._null.balance.bent(solution, self._null.balance.usable, self._structure)
        off = np.maximum(np.abs(solution.coefficients) - bent, 0.0)
        prices, at = dict[str, float](), 0
        for term in solution.terms:
            part = slice(at, at + term.columns.shape[0])
            found = float(np.sum((solution.prior[part] * off[part]) ** 2))
            prices[term.effect] = prices.get(term.effect, 0.0) + found
            at += term.columns.shape[0]
        for name, found in self._of_finer(solution, finer_forms).items():
            prices[name] = prices.get(name, 0.0) + found
        rubs = [one for name, one in prices.items() if name.endswith(_FRICTION)]
        return sum(prices.values()) - sum(rubs) + max(rubs, default=0.0)

    def _of_finer(self, solution: Solution, names: Collection[str]) -> dict[str, float]:
        """Prices of the constants that finer forms stand for, by the effect of each."""
        null, finer = self._null, [one for one in solution.free if one.effect in names]
        refined = {name for one in finer for name in one.refines}
        stood_for = [one for one in null.uncertain if one.term.effect in refined]
        if not stood_for:
            return {}
        rows = null.balance.usable
        asked = sum(null.balance.columns([one])[rows] @ solution.of(one) for one in finer)
        found = _shares(null.balance.columns([one.term for one in stood_for])[rows], asked)
        made, at = dict[str, float](), 0
        for one in stood_for:
            size = _size(one.term)
            width = one.width * null.gained(solution)
            made[one.term.effect] = float(np.sum((2.0 * found[at : at + size] / width) ** 2))
            at += size
        return made


def _size(term: Term) -> int:
    return term.columns.shape[0]


def _shares(columns: FloatArray, values: FloatArray | int) -> FloatArray:
    """Coefficients of columns, float64[m, k], that come closest to values."""
    size = np.sqrt(np.mean(columns**2, axis=0)) + 1e-300
    made: FloatArray = np.linalg.lstsq(columns / size, values, rcond=None)[0] / size
    return made
