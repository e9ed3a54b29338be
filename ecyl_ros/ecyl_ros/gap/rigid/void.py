"""Whether a fitted effect stands for something: off its neutral value, off its bounds, possible."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...effects.actuation_delay import SAMPLING
from ...effects.along import Along
from ...effects.catalogue import RIGID
from ...effects.term import Interval, Term
from ..diagnosis import FloatArray
from .balance import Balance, Solution
from .sheet import sheet_value, within

SHEET = "within the tolerance of the data sheet"
SILENT = (SAMPLING, SHEET)  # what every sound machine, and every recording, may show


@dataclass(frozen=True, eq=False)
class _Fitted:
    """See `effects.term.Fitted`; `first`: where its coefficients begin among the solution's."""

    along: Along
    balance: Balance
    solution: Solution
    term: Term
    spans: Sequence[Interval]
    first: int

    @property
    def values(self) -> FloatArray:
        """Its coefficients."""
        return self.solution.of(self.term)

    def covariance(self) -> FloatArray:
        """Of its coefficients."""
        own = slice(self.first, self.first + self.term.columns.shape[0])
        return self.balance.covariance(self.solution, self.balance.usable)[0][own, own]

    def inflation(self, by: Sequence[Term]) -> float:
        """Variance inflation of its first column."""
        rows = self.balance.usable
        own = self.balance.columns([self.term])[rows, 0]
        other = self.balance.columns(by)[rows]
        rest = own - other @ np.linalg.lstsq(other, own, rcond=None)[0]
        return float(np.sum(own**2) / max(np.sum(rest**2), 1e-300))


def why_not(
    balance: Balance,
    along: Along,
    solution: Solution,
    term: Term,
    spans: Sequence[Interval],
    first: int,
) -> str:
    """Why a fitted term is no cause; empty where nothing speaks against it.

    Args:
        balance, along, solution: the fit of all usable rows.
        term: one of its terms. spans: its parameters with their 95 % intervals.
        first: where its first coefficient stands among the solution's.
    """
    told = sheet_value(term, spans, along.machine, along.units)
    if told is not None and within(told):
        return SHEET
    return RIGID[term.effect].void(_Fitted(along, balance, solution, term, spans, first))
