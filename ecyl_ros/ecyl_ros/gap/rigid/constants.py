"""The constants of a file refitted beside what is found, no better known than their tolerance."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ...drive.rigid.machine import KEYS
from ...effects.catalogue import RIGID, rigid_forms
from ...effects.term import Term
from ..diagnosis import BoolArray
from .balance import Balance, Solution
from .terms import Catalogue

_GAIN = "actuation.gain"


def refitted(
    balance: Balance,
    catalogue: Catalogue,
    terms: Sequence[Term],
    void: Mapping[str, str],
    rows: BoolArray | None = None,
) -> Solution:
    """A fit of `terms` and of every constant of the data sheet that none of them stands for.

    void: by key of the term, why it is no cause; empty where it may be one. What a tolerance
    allows is a constant, whether it competed or not. rows: bool[m], all that are fitted unless
    given.
    """
    widths = _widths(catalogue)
    linear = catalogue.machine.linear
    causes = [one for one in terms if not void.get(one.key)]
    taken = {name for one in causes for name in (one.effect, *one.refines)}
    keys = {one.key for one in terms}
    more = [
        form.term(catalogue.along)
        for name, form in rigid_forms(linear).items()
        if form.constant[not linear] in widths and name not in taken
    ]
    every = [*terms, *(one for one in more if one.key not in keys)]
    prior = []
    for one in every:
        key = RIGID[one.effect].constant[not linear]
        own = key in widths and not any(one is cause for cause in causes)
        prior += [2.0 / widths[key] if own else 0.0, *[0.0] * (one.columns.shape[0] - 1)]
    return balance.fit(every, rows, prior=np.array(prior))


def _widths(catalogue: Catalogue) -> dict[str, float]:
    """Half widths of the uncertain constants, by key, in what their term is counted in."""
    machine = catalogue.machine
    if not catalogue.units.own:
        return {}
    found = {
        key: width
        for key, width in machine.half_widths().items()
        if width > 0.0 and not any(_stands_for(one.name, key) for one in machine.effects)
    }
    if _GAIN in found:
        found[_GAIN] /= float(getattr(machine, KEYS[_GAIN].field))
    return found


def _stands_for(effect: str, key: str) -> bool:
    return key in RIGID[effect].constant
