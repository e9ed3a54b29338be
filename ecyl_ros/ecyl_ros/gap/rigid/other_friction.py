"""Friction of the other form, which every machine has: what a motion tells only as a sum of both.

At one speed a level and friction in proportion to speed are one, and so they are while a steady
effort accelerates what the file does not weigh. A fit takes the simpler of them for all; how much
of it may be the other's is said by its interval.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ...effects import load_coulomb_friction as coulomb
from ...effects import load_viscous_friction as viscous
from ...effects.along import Along
from ...effects.term import Interval
from .balance import Balance
from .beside import with_more
from .solution import Solution
from .uncertainty import intervals

Spans = Mapping[str, Sequence[Interval]]


def as_a_sum(
    balance: Balance, along: Along, closest: Solution, spans: Spans
) -> tuple[dict[str, Interval], dict[str, str]]:
    """Friction of one form in a set, whose other form neither set nor file has; by key of its term.

    First its size, whose interval reaches down to where the other form has as much as it may, which
    is never less than none. Then the other form's effect, where that may be all of it.

    spans: 95 % intervals of the set's terms.
    """
    wider: dict[str, Interval] = {}
    taken: dict[str, str] = {}
    forms = [coulomb.term(along), viscous.term(along)]
    names = {name for one in closest.terms for name in (one.effect, *one.refines)}
    for own, other in (forms, forms[::-1]):
        alone = own.key in spans and other.effect not in names
        if not alone or other.effect not in along.unstated:
            continue
        both = intervals(balance, with_more(balance, closest, [other]), balance.usable)
        if both[other.key][0].high <= 0.0:
            continue
        first, beside = spans[own.key][0], both[own.key][0]
        wider[own.key] = first._replace(low=min(first.low, beside.low))
        if beside.low <= 0.0:
            taken[own.key] = other.effect
    return wider, taken
