"""What people play instead, within the same limits and time: sine, chirp, multisine, moves."""

from __future__ import annotations

import itertools
import math

import numpy as np

from ..drive.parameters import LimitParameters
from ..drive.reference.base import Reference
from ..drive.reference.chirp import Chirp
from ..drive.reference.leg import Leg
from ..drive.reference.multisine import Multisine
from ..drive.reference.planned import Planned
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

    rooms = (reach, *(_SHARE * one for one in (limits.speed, limits.acceleration, limits.jerk)))

    def largest(rate_rad_s: float) -> float:
        """Amplitude of the largest sine, m."""
        return min(room / rate_rad_s**order for order, room in enumerate(rooms))

    unit = Multisine(1.0, _LOW_HZ, _HIGH_HZ, _BASE_HZ)
    times = np.linspace(0.0, 1.0 / _BASE_HZ, _SAMPLES)
    shown = np.array([unit.sample(one) for one in times]).T
    faster = np.gradient(shown[1], times)
    peaks = [float(np.max(np.abs(one))) for one in (*shown, faster, np.gradient(faster, times))]
    lines = min(room / peak for room, peak in zip(rooms, peaks, strict=True))
    return {
        "sine": Sine(amplitude=largest(rate), frequency=_SINE_HZ),
        "chirp": Chirp(amplitude=largest(top), start=_LOW_HZ, end=_HIGH_HZ, sweep=duration_s),
        "multisine": Multisine(lines, _LOW_HZ, _HIGH_HZ, _BASE_HZ),
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
