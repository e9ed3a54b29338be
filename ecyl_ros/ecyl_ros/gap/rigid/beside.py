"""Friction and a load beside a set of causes: every machine may have them, named or not."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...effects import constant_load as constant
from ...effects import load_coulomb_friction as coulomb
from ...effects import load_viscous_friction as viscous
from ...effects.along import Along
from ...effects.term import Interval, Term
from .balance import Balance
from .solution import Solution
from .terms import free_means
from .uncertainty import intervals


def with_more(balance: Balance, closest: Solution, more: Sequence[Term]) -> Solution:
    """A set with terms that have a free size beside it, fitted to all rows."""
    free = np.zeros(sum(one.columns.shape[0] for one in more))
    prior = np.concatenate([closest.prior, free])
    return balance.fit([*closest.terms, *more], balance.usable, prior=prior)


def shown(
    balance: Balance, along: Along, closest: Solution, extra: Sequence[Term] = ()
) -> list[Term]:
    """Friction and a load that are neither in a set nor `extra`, and differ from none by their
    intervals beside both."""
    terms = [*closest.terms, *extra]
    every = [viscous.term(along)]
    if along.both_ways:  # else the one is the other
        every += [coulomb.term(along), constant.term(along)]
    keys = {one.key for one in terms}
    told = {name for one in terms for name in (one.effect, *one.refines, *one.holds)}
    more = [
        one
        for one in every
        if one.key not in keys
        and not told.intersection((one.effect, *one.refines))
        and not (one.mean and free_means(terms))
    ]
    while more:
        fit = with_more(balance, closest, [*extra, *more])
        spans = intervals(balance, fit, balance.usable)
        first = {one.key: spans[one.key][0] for one in more}
        idle = [one for one in more if first[one.key].low <= 0.0 <= first[one.key].high]
        if not idle:
            break
        more.remove(min(idle, key=lambda one: _sureness(first[one.key])))
    return more


def _sureness(span: Interval) -> float:
    return abs(span.value) / max(span.high - span.low, 1e-300)
