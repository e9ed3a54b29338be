"""The effort that a motion asks of a machine, in closed form, its friction sliding."""

from __future__ import annotations

import math

import numpy as np

from ....arrays import FloatArray
from .equations import STEP_S, Truth


def demand(
    truth: Truth,
    time: FloatArray,
    position: FloatArray,
    speed: FloatArray,
    acceleration: FloatArray,
) -> FloatArray:
    """What has to be recorded as effort for a motion, float64[n], in the output's own unit.

    time, position, speed, acceleration: float64[n] on an even grid.
    """
    ahead = speed >= 0.0
    level = np.where(ahead, *truth.coulomb).astype(float)
    level += truth.static * np.exp(-((speed / truth.stribeck) ** 2))
    level *= 1.0 + truth.drift_per_s * time
    amplitude, rate, phase = truth.gravity
    carried = truth.inertia * acceleration + truth.constant + truth.stiffness * position
    carried += amplitude * np.sin(rate * position + phase)
    level += truth.carried * np.abs(carried)
    height, middle, width = truth.jam
    if height:
        share = np.clip(0.5 + (0.5 * width - np.abs(position - middle)) / (0.15 * width), 0.0, 1.0)
        level += height * 0.5 * (1.0 - np.cos(math.pi * share))
    load = carried + np.where(ahead, *truth.viscous) * speed + level * np.sign(speed)
    for (amplitude, rate, phase), along in ((truth.cogging, position), (truth.sine, time)):
        load += amplitude * np.sin(rate * along + phase)
    fraction, rate, phase = truth.ripple
    load /= 1.0 - fraction * np.sin(rate * position + phase)
    if truth.winding[0]:
        load += truth.gain * truth.winding[1] / truth.winding[0] * speed
    if truth.delay_steps:
        load = np.interp(time + truth.delay_steps * STEP_S, time, load)
    return load
