"""What a fit says of the values of its terms: 95 % intervals, as wide as what else may act."""

from __future__ import annotations

from functools import cached_property

from ...effects.along import Along
from ...effects.term import Interval, Term
from .balance import Balance
from .beside import shown, with_more
from .other_friction import as_a_sum
from .rest import moving
from .solution import Solution
from .uncertainty import intervals

Spans = dict[str, list[Interval]]


class Values:
    """The terms of a set, fitted to all usable rows.

    Attributes:
        fit: the set and the file's constants. spans: 95 % intervals by key of the term, were there
            nothing but noise beside it.
    """

    def __init__(self, balance: Balance, along: Along, floor: float, fit: Solution) -> None:
        """floor: standard deviation of what cannot be explained."""
        self._balance, self._along, self._floor = balance, along, floor
        self.fit = fit
        self.spans: Spans = intervals(balance, fit, balance.usable)

    @cached_property
    def told(self) -> Spans:
        """`bent`, as wide as those beside friction and a load that are shown without being named,
        or could be: what is reported.

        At one speed a level stands for all friction; its value is then that of a sum.
        """
        _, beside = self.beside
        told = {
            key: [one.over(other) for one, other in zip(spans, beside[key], strict=True)]
            for key, spans in self.bent.items()
        }
        for key, first in self._as_a_sum[0].items():
            told[key][0] = told[key][0].over(first)
        return told

    @cached_property
    def bent(self) -> Spans:
        """`spans`, as wide as the structure that is left could bend them."""
        return intervals(self._balance, self.fit, self._balance.usable, self.structure)

    @cached_property
    def structure(self) -> float:
        """RMS of the structure that is left, as far as it may be along one effect."""
        in_motion = moving(self._balance.usable, self._balance.motion, self._along)
        return self.fit.bends(in_motion, self._floor)

    @cached_property
    def beside(self) -> tuple[list[Term], Spans]:
        """Friction and a load that are shown without being in the set, and `spans` beside them."""
        more = shown(self._balance, self._along, self.fit)
        if not more:
            return [], self.spans
        fit = with_more(self._balance, self.fit, more)
        return more, intervals(self._balance, fit, self._balance.usable)

    def taken_over(self, term: Term) -> list[str]:
        """Effects that are shown without being in the set, or may be of any machine, beside which a
        term may be nothing."""
        more, beside = self.beside
        first = beside[term.key][0]
        others = [one.effect for one in more] if first.low <= 0.0 <= first.high else []
        other = self._as_a_sum[1].get(term.key)
        return others if other is None or other in others else [*others, other]

    @cached_property
    def _as_a_sum(self) -> tuple[dict[str, Interval], dict[str, str]]:
        return as_a_sum(self._balance, self._along, self.fit, self.bent)
