"""The band in which the inertia of a rigid drive is what all lower bands say it is.

Noise of the motion that is not white (an encoder off its centre), and parts that are not rigid,
bend an inertia the more the faster they are. The widest band is taken whose inertia lies within
the intervals of all lower ones, 95 % together (Lepskii, "On a problem of adaptive estimation in
Gaussian white noise", 1991; the test is that of Hausman, "Specification tests in econometrics",
1978).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

from scipy.special import ndtri

from ...drive.rigid.machine import Machine
from ...effects.term import Interval, Term
from .balance import Balance
from .noise import blur_of, in_lower_band
from .solution import Solution

_PERIODS = (
    2.0  # of a band in a stretch: more slowly, what is left of one stretch is that of another
)


def where_inertia_holds(
    balance: Balance, machine: Machine, terms: Sequence[Term]
) -> tuple[Balance, Solution]:
    """The balance in that band and the fit of `terms` to all of it; as it is if none tells it."""
    fit = balance.fit(terms, balance.usable)
    found = [(balance, fit, _inertia(balance, fit))]
    if found[0][2] is None:
        return balance, fit
    for lower in _lower(balance, lambda: fit.inertia(balance.model), machine):
        then = lower.fit(terms, lower.usable)
        found.append((lower, then, _inertia(lower, then)))
    for at, (wide, made, told) in enumerate(found):
        below = [span for _, _, span in found[at + 1 :]]
        wider = _together(len(below))
        if told is not None and all(
            span is not None
            and abs(told.value - span.value) <= wider * 0.5 * (span.high - span.low)
            for span in below
        ):
            return wide, made
    return balance, fit


def _together(count: int) -> float:
    """By how much 95 % intervals are wider where 95 % of all sets of `count` are to hold."""
    return float(ndtri(1.0 - 0.025 / max(count, 1)) / ndtri(0.975))


def _within(value: float, span: Interval | None, wider: float) -> bool:
    if span is None:
        return False
    return abs(value - span.value) <= 0.5 * wider * (span.high - span.low)


def _inertia(balance: Balance, fit: Solution) -> Interval | None:
    """What its term adds to it."""
    spans = balance.intervals(fit, balance.usable)
    return spans["inertia"][0] if "inertia" in spans else None


def _lower(balance: Balance, inertia: Callable[[], float], machine: Machine) -> Iterator[Balance]:
    """The same balance, each time in half the band, as far down as the recording is long enough."""
    motion = balance.motion
    hertz = 0.5 * min(motion.weight_hz, motion.bandwidth_hz)
    while hertz * balance.stretch_s >= _PERIODS:
        lower = in_lower_band(motion, hertz)
        if lower is None:
            break
        yield Balance(
            lower, balance.nominal, balance.model, blur_of(lower, machine, inertia()), balance.lag_s
        )
        hertz *= 0.5
