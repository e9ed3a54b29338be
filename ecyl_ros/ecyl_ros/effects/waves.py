"""The sine that cogging, ripple, a disturbance and the weight of an arm share."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from ..arrays import FloatArray
from ..drive.compiled import kernel
from .along import Along
from .rigid_form import Stem, Values
from .term import Left, Parameters, Term


@kernel
def wave(amplitude, rate, phase, at):
    """A sine of angle or time."""
    return amplitude * math.sin(rate * at + phase)


def quadratures(phase: FloatArray) -> FloatArray:
    """Columns float64[2, n] that a sine of any amplitude and phase is a sum of."""
    return np.stack([np.sin(phase), np.cos(phase)])


def parts(amplitude: float, phase: float) -> tuple[float, float]:
    """Coefficients of `quadratures` in amplitude x sin(x + phase)."""
    return amplitude * math.cos(phase), amplitude * math.sin(phase)


def size(coefficients: FloatArray) -> float:
    """Amplitude."""
    return float(np.hypot(coefficients[0], coefficients[1]))


def begin(coefficients: FloatArray) -> float:
    """Phase."""
    return math.atan2(float(coefficients[1]), float(coefficients[0]))


def phase_stem(meaning: str) -> Stem:
    """Where the sine begins."""
    return Stem("phase", "angle", -10.0, 10.0, f"of the sine at {meaning}", default=0.0)


def sine(
    phase_rad: FloatArray,
    stem: str,
    first: tuple[str, str],
    found: Parameters = (),
    stems: Values | None = None,
    whole: bool = False,
    **more: Any,
) -> Term:
    """A sine along the motion, float64[n], of any amplitude and phase.

    stem: what its amplitude is inside, with name and unit of its parameter in `first`. found: its
    rate, which was searched; the same by stem in `stems`. whole: whether that can only be a whole
    number.
    """
    fixed = {name: value for name, _, value in found}
    apart = math.tau / float(np.ptp(phase_rad)) if found and not whole else 0.0  # one period more
    return Term(
        columns=quadratures(phase_rad),
        parameters=lambda c: ((*first, size(c)), *found),
        values=lambda c: {
            stem: size(c),
            "phase": begin(c),
            **(stems or {}),
        },
        low=(-math.inf, -math.inf),
        fixed=fixed,
        reach={name: apart * value for name, value in fixed.items() if apart},
        phase=phase_rad,
        **more,
    )


# Over the position: an order of the turn.

_ONCE = 0.1  # an order this near to 1 is once per turn
ORDER = (
    Stem("wave", "wave", 1e-6, 1e6, "periods per turn, or period of a straight output"),
    phase_stem("position 0"),
)


def over_turn(along: Along, order: float, stem: str, first: tuple[str, str], **more: Any) -> Term:
    """A sine of an order over the turn; see `sine`."""
    angle, name, unit, rate = along.turn
    shown = math.tau / order if name == "period_m" else order
    return sine(
        order * angle,
        stem,
        first,
        found=((name, unit, shown),),
        stems={"wave": order * rate},
        rate=order,
        whole=name == "periods_per_rev" and order == round(order) and along.turns,
        **more,
    )


def order_in(along: Along, fixed: Mapping[str, float]) -> float:
    """The order that a term over the turn was searched to."""
    return math.tau / fixed["period_m"] if "period_m" in fixed else fixed[along.turn.name]


def once_per_turn(order: float, name: str) -> tuple[str, ...]:
    """What else makes one line per turn: a scale off its centre, a weight off the axis."""
    if name == "period_m" or abs(order - 1.0) > _ONCE:
        return ()
    screw = name == "periods_per_screw_rev"
    return ("encoder_eccentricity",) if screw else ("encoder_eccentricity", "gravity_on_arm")


def nearest_order(left: Left, other: Term) -> tuple[float]:
    """The order of the sine over the turn that comes closest to another's; 0 where none can."""
    return (left.nearest(other, False) if other.over_time else other.rate,)
