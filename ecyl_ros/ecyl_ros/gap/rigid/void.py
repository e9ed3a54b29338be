"""Whether a fitted effect stands for something: off its neutral value, off its bounds, possible."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ...arrays import FloatArray
from ...effects import constant_load
from ...effects.actuation_delay import SAMPLING
from ...effects.along import Along
from ...effects.catalogue import RIGID
from ...effects.term import Fitted, Interval, Term
from .balance import Balance, beside
from .floor import white_part
from .sheet import sheet_value, within
from .solution import Solution
from .uncertainty import half_width, intervals

_PARTS = 4  # of the time, in which a sine has to be the same
_OTHER = 0.5  # of its size, that it may be another in a part of the time
_SURE = 3.0  # standard errors that it has to be another by
_EXPLAINS = 0.5  # of the effort's RMS: a model that leaves more has hardly any of it
_UNSURE = 0.1  # of the power of white noise, as its least density tells it
SHEET = "within the tolerance of the data sheet"
SILENT = (SAMPLING, SHEET)  # what every healthy machine, and every recording, may show


def why_not(
    balance: Balance,
    along: Along,
    solution: Solution,
    term: Term,
    spans: Sequence[Interval],
    first: int,
    left: float = 0.0,
) -> str:
    """Why a fitted term is no cause; empty where nothing speaks against it.

    Args:
        balance, along, solution: the fit of all usable rows.
        term: one of its terms. spans: its parameters with their 95 % intervals.
        first: where its first coefficient stands among the solution's.
        left: RMS of the structure that is still left, which may bend its values.
    """
    told = sheet_value(term, spans, along.machine, along.units)
    if told is not None and within(told):
        return SHEET
    if _drowns(balance, along, solution, term):
        return "the model explains too little of the effort to show a smaller value"
    if term.phase.size and _comes_and_goes(balance, solution, term):
        return "it is not there all the time, or not in step"
    rows, own = balance.usable, slice(first, first + term.columns.shape[0])

    def wide(combined: FloatArray) -> float:
        every = np.zeros(solution.coefficients.size)
        every[own] = combined
        return half_width(balance, solution, rows, every, left)

    def inflation(by: Sequence[Term]) -> float:
        column = balance.columns([term])[rows, 0]
        rest = beside(column, balance.columns(by)[rows])
        return float(np.sum(column**2) / max(np.sum(rest**2), 1e-300))

    def among(by: Sequence[Term]) -> Sequence[Interval]:
        kept = [one for one in solution.terms if one.key not in {other.key for other in by}]
        costs = np.repeat(
            [one in kept for one in solution.terms],
            [one.columns.shape[0] for one in solution.terms],
        )
        free = np.zeros(sum(one.columns.shape[0] for one in by))
        prior = np.concatenate([solution.prior[costs], free])
        full = balance.fit([*kept, *by], rows, prior=prior)
        return intervals(balance, full, rows)[term.key]

    fitted = Fitted(
        along=along,
        term=term,
        values=solution.of(term),
        spans=spans,
        half_width=wide,
        inflation=inflation,
        beside=among,
    )
    return RIGID[term.effect].void(fitted)


def _drowns(balance: Balance, along: Along, solution: Solution, term: Term) -> bool:
    """Whether a constant is less than its nominal value in a model that explains next to nothing.

    What the nominal model asks for too much then comes off best, and nothing in its place. White
    noise of the effort is neither explained nor left: it makes no value smaller. A load has either
    sign: it is less where it goes against that of the file.
    """
    more = float(solution.of(term)[0])
    if term.effect == constant_load.EFFECT.name:
        more *= along.model.constant
    if not (any(RIGID[term.effect].constant) and more < 0.0):
        return False
    rows = balance.usable
    effort = float(np.var(balance.effort[rows]))
    white = white_part(balance, solution) ** 2
    left = max(solution.rms(rows) ** 2 - white, _UNSURE * white)
    return left > _EXPLAINS**2 * (effort - white)


def _comes_and_goes(balance: Balance, solution: Solution, term: Term) -> bool:
    """Whether a sine gives something else, by size or phase, in some part of the time.

    By what it gives where the motion went: over a small arc very different sines are one.
    """
    columns, values = balance.columns([term]), solution.of(term)
    target = solution.residual + columns @ values
    rows = np.flatnonzero(balance.usable)
    for part in np.array_split(rows, _PARTS):
        there = np.any(columns[part] != 0.0, axis=0)  # of the recordings that it is in
        inside = columns[part][:, there]
        found, *_ = np.linalg.lstsq(inside, target[part], rcond=None)
        left = float(np.mean((target[part] - inside @ found) ** 2))
        # Neighbouring samples say the same thing: stretches count, not samples.
        pieces = max(np.unique(balance.stretch[part]).size, 2)
        spread = math.sqrt(inside.shape[1] * left / pieces)
        size = float(np.sqrt(np.mean((inside @ values[there]) ** 2)))
        off = float(np.sqrt(np.mean((inside @ (found - values[there])) ** 2)))
        if off > _OTHER * size and off > _SURE * spread:
            return True
    return False
