"""Two causes at once: where to begin, told by what each of them comes to alone.

Causes that hide each other (friction on both sides of the play, a load and the friction that holds
it) have a valley so narrow that neither is found upon the best fit of the other: that fit stands in
for both. The true sizes lie between: the nearer two effects are alike, the nearer to the line from
one alone to the other alone, and where they have nothing in common, both have the sizes they have
alone.
"""

from __future__ import annotations

import functools
from collections.abc import Sequence
from itertools import combinations, product

from ...drive.parameters import DriveParameters
from ...effects.catalogue import CATALOGUE
from ..fit.fit import Fit, Fitter, Values
from ..side_by_side import side_by_side

_SINGLES = 7  # that are joined, the best
_SHARES = (0.25, 0.5, 0.75, 1.0)  # of the size alone
_LEAST = 0.8  # that the shares of two must come to


def resized(single: Fit, size: float, drive: DriveParameters) -> Values:
    """A single effect at `size` times its fitted size."""
    (name,) = single.names
    return {name: CATALOGUE[name].scaled(single.values[name], size, drive)}


def joined(fitter: Fitter, singles: Sequence[Fit]) -> list[Fit]:
    """Sets of two of the best single effects in the shares that leave least, best first.

    Args:
        singles: fits of one effect each, best first.
    """
    drive = fitter.replay.drive
    # A general case of another effect here would only be the same again with more freedom.
    names = {name for one in singles for name in one.names}
    plain = [one for one in singles if not names.intersection(CATALOGUE[one.names[0]].refines)]
    sizes = [pair for pair in product(_SHARES, repeat=2) if sum(pair) > _LEAST]
    best = []
    # Pair by pair: a fit holds whole signals, and hundreds of them would fill the memory.
    for first, second in combinations(plain[:_SINGLES], 2):
        jobs = [
            {**resized(first, one, drive), **resized(second, other, drive)} for one, other in sizes
        ]
        pulls = 0.5 * (first.pulls + second.pulls)
        tried = side_by_side(functools.partial(fitter.evaluate, pulls=pulls), jobs)
        best.append(min(tried, key=lambda one: one.fitted))
    return sorted(best, key=lambda one: one.fitted)
