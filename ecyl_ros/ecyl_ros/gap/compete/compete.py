"""Which effects close the gap: all of them compete, alone and in sets, judged on what no fit saw.

0. The sheet alone: the constants, each at the price of leaving its tolerance. What follows has them
   free at the same price, and has to beat this. Where it comes to the noise, none but a constant
   far off it competes.
1. Every effect is started from what the recording shows (regressions, lines, multiples of the
   nominal value) and replayed once per start.
2. The most promising are fitted in closed loop; the best of these with their shape parameters too.
3. Where one effect does not bring the model to the noise floor, sets of two and three are tried:
   candidates come from the responses already at hand, added up with free sizes, from fresh starts
   on what the best single effects leave, and from these in shares of the sizes they have alone. In
   sets of two the next best alone are tried in the place of what is best alone; in the best of
   all, finer forms of its effects begin again.
4. An effect stays in a set only if leaving it out costs clearly more than it adds in freedom.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from ..fit.fit import Fit, Fitter
from .candidates import Candidates
from .carried import carried_over
from .competition import Competition, enough, others, pruned
from .earn import at_noise, earns, surely_at_noise
from .far_off import far_off
from .forms import Forms

_FIRSTS = 2  # single effects that sets are built upon
_MOST_EFFECTS = 3

Report = Callable[[str, float], None]


def compete(
    fitter: Fitter, names: Sequence[str], report: Report, begun: Competition | None = None
) -> Competition:
    """Let the effects `names` compete for the gap that the bare model leaves.

    report: takes a stage and the share done. begun: the same on some of the recordings.
    """
    field = Candidates(fitter, names)
    if fitter.divided_by(field.null):
        field = Candidates(fitter, names)
    nominal = fitter.nominal
    forms = Forms(field)
    fitter.test_floor(field.null)
    if field.null is not nominal and surely_at_noise(fitter, field.null):
        return _sheet_or_far_off(field, nominal)
    if field.shaken_loose():
        fitter.replay.shake()
    found = carried_over(field, forms, begun) if begun is not None else None
    if found is not None:
        return found
    singles = field.singles(lambda share: report("single effects", 0.05 + 0.4 * share))
    if singles and field.sheet_from(singles[0]):
        if at_noise(fitter, field.null):
            return Competition(nominal, field.null, (), field.null, (), {})
        singles = field.singles(lambda share: report("single effects", 0.45 + 0.15 * share))
    null = field.null
    if singles:
        fitter.test_floor(singles[0])
    if null is not nominal and at_noise(fitter, null):
        return Competition(nominal, null, (), null, (), {})
    winner = null
    rivals: list[Fit] = []
    pool = list(singles)
    best = field.settled(forms.simplified(singles[0])) if singles else null
    if singles and earns(fitter, best, null):
        winner = best
        rivals = others(singles, best)
    # Sets of two are built upon single effects, even where one was told as two simpler ones.
    firsts = singles[:_FIRSTS] if len(best.names) > 1 else [best, *others(singles, best)][:_FIRSTS]
    size, unsearched = 2, 0
    while not enough(fitter, best, size) and size <= _MOST_EFFECTS and firsts:
        if size > 2 and field.costly():
            unsearched = size
            break
        report(f"sets of {size}", 0.5 + 0.1 * size)
        fitted = field.larger(firsts, singles)
        if not fitted:  # no effect is left to add
            break
        if len(winner.names) == size:
            fitted = sorted([winner, *fitted], key=lambda one: one.fitted)
        report(f"sets of {size}", 0.6 + 0.1 * size)
        fitter.test_floor(fitted[0])
        pool += fitted
        best = field.settled(forms.simplified(fitted[0], fitted))
        if size == 2 and not surely_at_noise(fitter, best):
            fitted = field.exchanged([best, *fitted])
            fitter.test_floor(fitted[0])
            if fitted[0] is not best:
                best = field.settled(forms.simplified(fitted[0], fitted))
        if not at_noise(fitter, best):
            best = forms.finer(best)
        if earns(fitter, best, winner):
            winner = best
        elif len(winner.names) < size:
            break
        best = winner
        rivals = [one for one in fitted if set(one.names) != set(best.names)]
        firsts = [best, *others(fitted, best)][:_FIRSTS]
        size += 1
    winner, without = pruned(field, field.settled(winner), pool)
    rivals.sort(key=lambda one: one.judged)
    return Competition(nominal, null, tuple(singles), winner, tuple(rivals), without, unsearched)


def _sheet_or_far_off(field: Candidates, nominal: Fit) -> Competition:
    """Where the sheet alone comes to the noise: it, or a constant far off it that comes nearer."""
    null = field.null
    far = [one for one in far_off(field) if earns(field.fitter, one, null)]
    if not far:
        return Competition(nominal, null, (), null, (), {})
    winner, without = pruned(field, field.settled(far[0]), far)
    return Competition(nominal, null, tuple(far), winner, tuple(others(far, winner)), without)
