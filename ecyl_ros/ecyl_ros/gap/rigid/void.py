"""Whether a fitted effect stands for something: off its neutral value, off its bounds, possible."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...effects.actuation_delay import SAMPLING
from ...effects.along import Along
from ...effects.catalogue import RIGID
from ...effects.term import Fitted, Interval, Term
from .balance import Balance, Solution, beside
from .sheet import sheet_value, within

SHEET = "within the tolerance of the data sheet"
SILENT = (SAMPLING, SHEET)  # what every sound machine, and every recording, may show


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
    rows, own = balance.usable, slice(first, first + term.columns.shape[0])

    def inflation(by: Sequence[Term]) -> float:
        column = balance.columns([term])[rows, 0]
        rest = beside(column, balance.columns(by)[rows])
        return float(np.sum(column**2) / max(np.sum(rest**2), 1e-300))

    fitted = Fitted(
        along=along,
        term=term,
        values=solution.of(term),
        spans=spans,
        covariance=lambda: balance.covariance(solution, rows)[0][own, own],
        inflation=inflation,
    )
    return RIGID[term.effect].void(fitted)
