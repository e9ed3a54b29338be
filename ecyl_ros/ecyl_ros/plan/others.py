"""What people play instead, within the same limits and time: sine, chirp, multisine, moves."""

from __future__ import annotations

import itertools
import math

import numpy as np

from ..drive.parameters import LimitParameters
from ..drive.reference.base import Reference
from ..drive.reference.chirp import Chirp
from ..drive.reference.multisine import Multisine
from ..drive.reference.planned import Leg, Planned
from ..drive.reference.sine import Sine
from .blocks import widest

MOVES = "moves"  # the name of the last
_SINE_HZ = 1.0
_LOW_HZ, _HIGH_HZ, _BASE_HZ = 0.5, 8.0, 0.25
_SAMPLES = 4000
_SHARE = 0.9  # of the limits
_MOVES_SEED = 3
_DWELL_S = 0.1


def usual(limits: LimitParameters, duration_s: float) -> dict[str, Reference]:
    """Each as large as the limits allow."""
    reach = _SHARE * min(limits.stroke_max, -limits.stroke_min)
    if reach <= 0.0:  # the start lies at an end of the stroke: what swings about it leaves it
        return {MOVES: moves(limits, duration_s)}
    rate, top = (2.0 * math.pi * one for one in (_SINE_HZ, _HIGH_HZ))
    sine = min(reach, _SHARE * limits.speed / rate, _SHARE * limits.acceleration / rate**2)
    chirp = min(reach, _SHARE * limits.speed / top, _SHARE * limits.acceleration / top**2)
    unit = Multisine(1.0, _LOW_HZ, _HIGH_HZ, _BASE_HZ)
    times = np.linspace(0.0, 1.0 / _BASE_HZ, _SAMPLES)
    shown = np.array([unit.sample(one) for one in times])
    faster = np.gradient(shown[:, 1], times)
    lines = min(
        reach / np.max(np.abs(shown[:, 0])),
        _SHARE * limits.speed / np.max(np.abs(shown[:, 1])),
        _SHARE * limits.acceleration / np.max(np.abs(faster)),
    )
    return {
        "sine": Sine(amplitude=sine, frequency=_SINE_HZ),
        "chirp": Chirp(amplitude=chirp, start=_LOW_HZ, end=_HIGH_HZ, sweep=duration_s),
        "multisine": Multisine(float(lines), _LOW_HZ, _HIGH_HZ, _BASE_HZ),
        MOVES: moves(limits, duration_s),
    }


def moves(limits: LimitParameters, duration_s: float) -> Planned:
    """Random moves at the drive's own limits, a short rest after each, and home at the end."""
    rng = np.random.default_rng(_MOVES_SEED)
    reach = widest(limits, duration_s / 4.0)
    low, high = max(limits.stroke_min, -reach), min(limits.stroke_max, reach)

    def leg(to: float) -> Leg:
        return Leg(to, limits.speed, limits.acceleration, limits.jerk, _DWELL_S)

    legs: list[Leg] = []
    for _ in itertools.repeat(None, 1000):
        more = [*legs, leg(float(rng.uniform(low, high)))]
        if Planned((*more, leg(0.0)), duration_s).moving_s > duration_s:
            break
        legs = more
    return Planned((*legs, leg(0.0)) if legs else (), duration_s)
