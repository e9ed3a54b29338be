"""What the noise of the recorded signals comes to within the band, as an effort."""

from __future__ import annotations

import math

import numpy as np

from .balance import Solution
from .band import DERIVATIVE, ORDER
from .grid import bridged
from .motion import Motion
from .terms import Catalogue
from .white import least_density

_POINTS = 2000  # of an integral over frequency


def effort_noise(motion: Motion, stated: float | None = None) -> float:
    """Standard deviation of the effort's white noise within the band.

    stated: of a sample, in the unit of the motion's effort; None: from above the band.
    """
    if stated is not None:
        return stated * math.sqrt(min(2.0 * motion.bandwidth_hz / motion.rate_hz, 1.0))
    density = least_density(motion.effort, motion.usable, motion.rate_hz, motion.bandwidth_hz)
    return math.sqrt(density * min(motion.bandwidth_hz, 0.5 * motion.rate_hz))


def acceleration_noise(motion: Motion, *, counted: bool = False) -> float:
    """Standard deviation of the acceleration's noise within the band.

    White noise of the position (of the speed, where acceleration comes from a recorded one), as
    dense as above the band, through differences and low-passes. counted: no less than the steps of
    the encoder make of it, whose noise is not white while it moves slowly.
    """
    rate, band = motion.rate_hz, motion.bandwidth_hz
    order, values = 2, motion.raw_position
    if motion.by_speed:
        order, values = 1, bridged(motion.recorded_velocity, np.isfinite(motion.recorded_velocity))
    density = least_density(values, motion.usable, rate, band, order)
    if counted:
        spread = motion.position_noise**2 / (0.5 * rate)
        density = max(density, spread * (math.tau * band) ** 2 if motion.by_speed else spread)
    frequency = np.linspace(0.0, 0.5 * rate, _POINTS)
    gain = (rate * np.sin(math.tau * frequency / rate)) ** order  # of central differences
    for cutoff in (band, min(DERIVATIVE * band, 0.45 * rate)):
        gain /= 1.0 + (frequency / cutoff) ** (2 * ORDER)  # forwards and backwards
    return math.sqrt(density * float(np.mean(gain**2)) * 0.5 * rate)


def measurement_noise(catalogue: Catalogue, fit: Solution) -> float:
    """Standard deviation that noise of effort and motion leaves of the balance.

    fit: of a set that tells the inertia where the file does not.
    """
    motion, machine = catalogue.motion, catalogue.machine
    stated = machine.effort_noise
    if stated is not None and machine.gain is not None and catalogue.units.own:
        stated *= machine.gain
    inertia = (catalogue.model.inertia or 0.0) + sum(
        float(fit.of(one)[0]) for one in fit.terms if one.key == "inertia"
    )
    return math.hypot(effort_noise(motion, stated), inertia * acceleration_noise(motion))
