"""Whether a fitted effect stands for something: off its neutral value, off its bounds, possible."""

from __future__ import annotations

import numpy as np

from .balance import Balance, Interval, Solution
from .compete import LATE
from .sheet import sheet_value, within
from .terms import Catalogue, Term

SAMPLING = "within the lag of sampling and holding"
SHEET = "within the tolerance of the data sheet"
SILENT = (SAMPLING, SHEET)  # what every sound machine, and every recording, may show
_AT_BOUND = 1e-6  # of a term's largest coefficient: so near, it is the bound
_INFLATED = 10.0  # beyond so much variance inflation columns count as one (Marquardt, 1970)
_RARE = 1.96  # standard deviations that 95 % of all lie within


def why_not(
    balance: Balance,
    catalogue: Catalogue,
    solution: Solution,
    term: Term,
    spans: list[Interval],
    spare: int,
) -> str:
    """Why a fitted term is no cause; empty where nothing speaks against it.

    Args:
        balance, catalogue, solution: the fit of all usable rows.
        term: one of its terms. spans: its parameters with their 95 % intervals.
        spare: where its first coefficient stands among the solution's.
    """
    told = sheet_value(term, spans, catalogue.machine, catalogue.units)
    if told is not None and within(told):
        return SHEET
    values = solution.of(term)
    nominal = catalogue.model.inertia or 0.0
    first = spans[0]
    if term.key == "inertia":
        if first.low <= 0.0:
            return f"its interval, {first.low:.3g} to {first.high:.3g}, holds 0"
        if first.low <= nominal <= first.high:
            return "its interval holds the value of the file"
        return ""
    if term.key == "gain":
        gain = catalogue.machine.gain or 1.0
        return "its interval holds the value of the file" if first.low <= gain <= first.high else ""
    if term.key == "delay" and first.value <= LATE / balance.motion.rate_hz:
        return SAMPLING
    if term.key == "by_direction":
        return _one_for_both(balance, solution, term, spare)
    low = np.array(term.low)
    bounded = np.isfinite(low)
    # A Coulomb level that a finer form brings with it may be 0; the surplus may not.
    if np.any(values[bounded] - low[bounded] <= _AT_BOUND * max(np.abs(values).max(), 1e-300)):
        return "it stands at its bound"
    shown = spans[1] if term.effect in ("friction_drift",) else first
    if term.effect == "stribeck_friction":
        half = max(spans[1].high - spans[1].value, 0.0)
        if spans[1].value - half <= spans[0].value:
            return "the surplus at rest is within its interval"
        return ""
    if term.key == "viscous" and _inflated(balance, catalogue, term) > _INFLATED:
        return "the speed varies too little to tell it from friction of one level or a constant"
    if shown.low <= 0.0 <= shown.high:
        return f"its interval, {shown.low:.3g} to {shown.high:.3g} {shown.unit}, holds 0"
    return ""


def _inflated(balance: Balance, catalogue: Catalogue, term: Term) -> float:
    """Variance inflation of a term by friction of one level and a constant, in the set or not."""
    rows = balance.usable
    own = balance.columns([term])[rows, 0]
    level = balance.columns([catalogue.coulomb(), catalogue.constant()])[rows]
    rest = own - level @ np.linalg.lstsq(level, own, rcond=None)[0]
    return float(np.sum(own**2) / max(np.sum(rest**2), 1e-300))


def _one_for_both(balance: Balance, solution: Solution, term: Term, at: int) -> str:
    """Friction by direction has to differ by direction, and to be friction in both."""
    values = solution.of(term)
    covariance = balance.covariance(solution, balance.usable)[0][at : at + 4, at : at + 4]
    low = np.array(term.low)
    if np.any(values - low <= _AT_BOUND * np.abs(values).max()):
        return "one direction stands at its bound"
    for one, other in ((0, 1), (2, 3)):
        gap = values[one] - values[other]
        spread = covariance[one, one] + covariance[other, other] - 2.0 * covariance[one, other]
        if abs(gap) > _RARE * np.sqrt(max(float(spread), 0.0)):
            return ""
    return "it is the same in both directions"
