"""A constant far off its sheet, in a valley that the sheet alone does not reach.

Held back by its price, the sheet goes down the valley that it is in: a clearance's stiffness of a
third of the stated one is played as a somewhat softer and better damped one. What is left then are
the impacts, few and large, and it passes for noise, though not as near as a true model comes.
"""

from __future__ import annotations

from ...effects.catalogue import CATALOGUE
from ..fit.fit import ALMOST, Fit
from ..fit.robust import misfit
from .candidates import STARTS, Candidates

_MOST = 2  # constants that are fitted


def far_off(field: Candidates) -> list[Fit]:
    """Constants that fit better than the sheet alone at once, where one of them begins; best first.

    Empty where the sheet alone leaves as little as a perfect model.
    """
    fitter, null = field.fitter, field.null
    if misfit(null.left) <= ALMOST * fitter.perfect:
        return []
    rows = {name: fitter.sheet.index(CATALOGUE[name].constant) for name in field.names}
    names = [name for name, row in rows.items() if row is not None and fitter.sheet.tolerance[row]]
    best: dict[tuple[str, ...], Fit] = {}
    for one in field.starts(null, names, STARTS):
        if one.fitted < min(best.get(one.names, null).fitted, null.fitted):
            best[one.names] = one
    nearest = sorted(best.values(), key=lambda one: one.fitted)[:_MOST]
    return sorted(field.polish(nearest), key=lambda one: one.fitted)
