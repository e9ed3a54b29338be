"""The sine that cogging, ripple, a disturbance and the weight of an arm share."""

from __future__ import annotations

import math

import numpy as np

from ..drive.compiled import kernel
from .along import Along
from .effect import FloatArray
from .rigid_form import Stem
from .term import Parameters


@kernel
def wave(amplitude, rate, phase, at):
    """A sine of angle or time."""
    return amplitude * math.sin(rate * at + phase)


def quadratures(phase: FloatArray) -> FloatArray:
    """Columns float64[2, n] that a sine of any amplitude and phase is a sum of."""
    return np.stack([np.sin(phase), np.cos(phase)])


def parts(amplitude: float, phase: float) -> FloatArray:
    """Coefficients of `quadratures` in amplitude x sin(x + phase)."""
    return np.array([amplitude * math.cos(phase), amplitude * math.sin(phase)])


def polar(name: str, coefficients: FloatArray) -> dict[str, float]:
    """The inverse of `parts`."""
    sine, cosine = map(float, coefficients)
    return {name: size(coefficients), "phase": math.atan2(cosine, sine)}


def size(coefficients: FloatArray) -> float:
    """Amplitude."""
    return float(np.hypot(coefficients[0], coefficients[1]))


def phase_stem(meaning: str) -> Stem:
    """Where the sine begins."""
    return Stem("phase", "angle", -10.0, 10.0, f"of the sine at {meaning}", default=0.0)


# Over the position: an order of the turn.

ORDER = (
    Stem("wave", "wave", 1e-6, 1e6, "periods per turn, or period of a straight output"),
    phase_stem("position 0"),
)


def shown(along: Along, order: float) -> float:
    """An order as its parameter has it."""
    return math.tau / order if along.turn.name == "period_m" else order


def order_parameters(along: Along, order: float) -> Parameters:
    """The parameter that tells an order."""
    return ((along.turn.name, along.turn.unit, shown(along, order)),)


def extent(along: Along, order: float) -> float:
    """Turns, or travel in m, over which an order was searched; 0 where it must be whole."""
    angle, name, *_ = along.turn
    if name == "periods_per_rev" and order == round(order) and along.turns:
        return 0.0
    travel = float(np.ptp(angle[along.motion.usable]))
    return travel if name == "period_m" else travel / math.tau
