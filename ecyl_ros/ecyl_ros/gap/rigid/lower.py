"""The band in which the inertia of a rigid drive is what all lower bands say it is.

Noise of the motion that is not white (an encoder off its centre), and parts that are not rigid,
bend an inertia the more the faster they are. The widest band is taken whose inertia lies within
the intervals of all lower ones, 95 % together (Lepskii, "On a problem of adaptive estimation in
Gaussian white noise", 1991; the test is that of Hausman, "Specification tests in econometrics",
1978).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from scipy.special import ndtri

from ...drive.rigid.machine import Machine
from ...effects import load_inertia_error as inertia_error
from ...effects.term import Interval, Term
from .balance import Balance
from .judge import Judgement
from .motion import Motion
from .noise import blur_of, in_lower_band
from .solution import Solution
from .uncertainty import intervals

_PERIODS = 2.0  # of a band in a stretch, so that what is left of one is not that of the next


def where_inertia_holds(
    balance: Balance, machine: Machine, terms: Sequence[Term], fit: Solution | None = None
) -> tuple[Balance, Solution]:
    """The balance in that band and the fit of `terms` to all of it; as it is if none tells it.

    fit: of `terms` to all of `balance`, where it was made already.
    """
    if fit is None:
        fit = balance.fit(terms, balance.usable)
    if all(one.key != "inertia" for one in terms):
        return balance, fit
    bands = [balance, *_lower(balance, fit.inertia(balance.model), machine)]
    fits = [fit, *(one.fit(terms, one.usable) for one in bands[1:])]
    told = [_inertia(one, made) for one, made in zip(bands, fits, strict=True)]
    # The lowest has none below that could disagree.
    at = next(at for at, one in enumerate(told) if _agreed(one, told[at + 1 :]))
    return bands[at], fits[at]


def rigid_band(judgement: Judgement) -> Motion | None:
    """The motion in that band, where the inertia, let go, is off its sheet and the band is lower
    than that of the motion; else None.

    Beyond its resonance a machine is not the one of the sheet: the rotor shakes alone. Nor does a
    band that was chosen by a stated inertia suit one of twice that.
    """
    balance, along, winner = judgement.balance, judgement.catalogue.along, judgement.contest.winner
    own = inertia_error.term(along)
    if not along.known_inertia:
        return None
    off = {*judgement.null.strained(winner), *winner.effects}
    terms = list(winner.free)
    # Beside what any machine may ask for along its motion: a weight would bend a low band's.
    keys, refined = {one.key for one in terms}, {name for one in terms for name in one.refines}
    smooth = [own, *judgement.catalogue.smooth()]
    terms += [one for one in smooth if one.key not in keys and one.effect not in refined]
    fit = balance.fit(terms, balance.usable)
    if own.effect not in off and _on_sheet(judgement, own, fit):
        return None
    within, _ = where_inertia_holds(balance, along.machine, terms, fit)
    return None if within is balance else within.motion


def _on_sheet(judgement: Judgement, own: Term, fit: Solution) -> bool:
    """Whether an inertia that was let go in a fit may lie within its tolerance."""
    found = _inertia(judgement.balance, fit)
    widths = [one.width for one in judgement.null.uncertain if one.term.effect == own.effect]
    ends = [own.parameters(np.array([sign * sum(widths)]))[0][2] for sign in (-1.0, 1.0)]
    return found.low <= max(ends) and min(ends) <= found.high


def _agreed(wide: Interval, below: Sequence[Interval]) -> bool:
    """Whether a value lies within the intervals of all lower bands, 95 % together."""
    wider = _together(len(below))
    return all(abs(wide.value - one.value) <= wider * 0.5 * (one.high - one.low) for one in below)


def _together(count: int) -> float:
    """By how much 95 % intervals are wider where 95 % of all sets of `count` are to hold."""
    return float(ndtri(1.0 - 0.025 / max(count, 1)) / ndtri(0.975))


def _inertia(balance: Balance, fit: Solution) -> Interval:
    """With what its term adds to it."""
    return intervals(balance, fit, balance.usable)["inertia"][0]


def _lower(balance: Balance, inertia: float, machine: Machine) -> Iterator[Balance]:
    """The same balance, each time in half the band, as far down as the recording is long enough."""
    motion = balance.motion
    hertz = 0.5 * motion.corner_hz
    while hertz * balance.stretch_s >= _PERIODS:
        lower = in_lower_band(motion, hertz)
        if lower is None:
            break
        yield Balance(
            lower, balance.nominal, balance.model, blur_of(lower, machine, inertia), balance.lag_s
        )
        hertz *= 0.5
