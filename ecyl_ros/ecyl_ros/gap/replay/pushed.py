"""A replay with torque from outside on rotor and load, given over time."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from ...arrays import FloatArray
from ...drive.compiled import kernel
from ...drive.engine import run_ticks


def pushed_at(instants: FloatArray, pushes: Iterable[tuple[FloatArray, FloatArray]]) -> FloatArray:
    """All torques together at instants float64[m]: float64[m, 2], N m on rotor and load.

    pushes: of each its times float64[n], s, and float64[2, n]; straight lines between them.
    """
    pushed = np.zeros((len(instants), 2))
    for at, pair in pushes:
        pushed += np.column_stack([np.interp(instants, at, one) for one in pair])
    return pushed


@kernel
def run_pushed(
    first_tick,
    ticks,
    every,
    reference,
    plant,
    cascade,
    pending,
    params,
    samples,
    inputs,
    torque,
    slopes,
):
    """`run_ticks` with torque on rotor and load; arguments as there.

    torque: float64[m, 2] at the reference's samples, N m, straight lines between them. slopes:
    1 / inertia of rotor and load. What a tick's torque does to speeds and angles is added at its
    end, as to a body that is free: an error of second order in the tick.
    """
    tick_s = params[0].tick
    for tick in range(first_tick, first_tick + ticks):
        run_ticks(tick, 1, every, reference, plant, cascade, pending, params, samples, inputs)
        index = tick // every
        share = (tick - index * every + 0.5) / every
        for side in range(2):
            now = (1.0 - share) * torque[index, side] + share * torque[index + 1, side]
            gained = now * slopes[side] * tick_s
            plant[2 * side] += 0.5 * gained * tick_s
            plant[2 * side + 1] += gained
