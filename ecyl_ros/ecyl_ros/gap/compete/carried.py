"""A competition on some of the recordings, carried over to all of them.

What a search has found on some is fitted to all. Where a set of it accounts for all there is, as a
search's would have to, no other search is needed: sets that were far from it on some recordings are
no nearer on all.
"""

from __future__ import annotations

from ..fit.fit import Fit
from ..side_by_side import side_by_side
from .candidates import BEHIND, KEPT_SINGLES, Candidates
from .competition import Competition, enough, others, pruned
from .earn import earns
from .forms import Forms


def carried_over(field: Candidates, forms: Forms, begun: Competition) -> Competition | None:
    """The competition that comes of the sets of `begun`; None where none of them is enough.

    field, forms: of all the recordings, with the sheet alone.
    """
    fitter, null = field.fitter, field.null
    far = BEHIND * begun.winner.fitted  # on some of the recordings already

    def near(one: Fit) -> Fit:
        start = fitter.evaluate(one.values, one.pulls)
        return start if one.fitted > far else field.near(start)

    sets = [begun.winner, *begun.rivals[:KEPT_SINGLES], *begun.singles[:KEPT_SINGLES]]
    unlike = {frozenset(one.names): one for one in reversed(sets) if one.names}
    pool = side_by_side(near, unlike.values())
    if not pool:
        return None
    reach = BEHIND * min(one.fitted for one in pool)
    winner, rivals = null, list[Fit]()
    for size in sorted({len(one.names) for one in pool}):
        fits = sorted((one for one in pool if len(one.names) == size), key=lambda one: one.fitted)
        if fits[0].fitted > reach:
            continue
        polished = field.front(fits)
        fits = sorted([*polished, *fits[len(polished) :]], key=lambda one: one.fitted)
        pool += polished
        fitter.test_floor(fits[0])
        best = field.settled(forms.simplified(fits[0], fits))
        if not earns(fitter, best, winner):
            continue
        winner, rivals = best, others(fits, best)
        if enough(fitter, best, size + 1):
            break
    else:
        return None
    winner, without = pruned(field, winner, pool)
    singles = sorted((one for one in pool if len(one.names) == 1), key=lambda one: one.fitted)
    rivals.sort(key=lambda one: one.judged)
    return Competition(fitter.nominal, null, tuple(singles), winner, tuple(rivals), without)
