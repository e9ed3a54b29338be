"""Rigid drives that a diagnosis has not seen: other friction, other steps, a loop of its own.

Nothing here is shared with what is fitted. Friction is a bristle (Dahl, "A solid friction model",
1968) that builds up over a presliding range, its level smoothed towards rest; a jam sets in along a
raised cosine; the speed is stepped by Heun's method every 50 us, the bristle by its exact solution.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ....drive.compiled import kernel
from ...diagnosis import FloatArray

STEP_S = 5e-5
NONE = (0.0, 0.0, 0.0)  # of what has three numbers


class Truth(NamedTuple):
    """A machine and its loop; SI of the output, effort in N or N m.

    viscous, coulomb: forwards, backwards. static, stribeck: level at rest beyond Coulomb, and the
    speed over which it falls. drift_per_s: of the friction level. carried: level over the load
    carried. jam: level, middle, width. cogging, gravity, ripple: amplitude (of the ripple a share),
    rad per position, phase. sine: amplitude, rad/s, phase. presliding: travel. delay_steps: steps
    of `STEP_S` from command to effort. gain: true effort per what is recorded as effort.
    position_kp, speed_kp, speed_ki, limit: of the loop, in effort. control_steps: steps of a tick.
    """

    inertia: float
    viscous: tuple[float, float]
    coulomb: tuple[float, float]
    presliding: float
    position_kp: float
    speed_kp: float
    speed_ki: float
    limit: float
    control_steps: int
    static: float = 0.0
    stribeck: float = 1.0
    drift_per_s: float = 0.0
    carried: float = 0.0
    jam: tuple[float, float, float] = NONE
    cogging: tuple[float, float, float] = NONE
    gravity: tuple[float, float, float] = NONE
    ripple: tuple[float, float, float] = NONE
    sine: tuple[float, float, float] = NONE
    constant: float = 0.0
    stiffness: float = 0.0
    delay_steps: int = 0
    gain: float = 1.0


@kernel
def _level(m, time, position, speed, carried):
    way = 0 if speed >= 0.0 else 1
    level = m.coulomb[way]
    if m.static > 0.0:
        level += m.static * math.exp(-((speed / m.stribeck) ** 2))
    level *= 1.0 + m.drift_per_s * time
    level += m.carried * abs(carried)
    if m.jam[0] != 0.0:
        edge = 0.15 * m.jam[2]
        inside = 0.5 * m.jam[2] - abs(position - m.jam[1])
        share = min(max(0.5 + 0.5 * inside / edge, 0.0), 1.0)
        level += m.jam[0] * 0.5 * (1.0 - math.cos(math.pi * share))
    return level


@kernel
def _net(m, time, position, speed, effort, bristle, level):
    """Force that accelerates: effort less all that opposes."""
    way = 0 if speed >= 0.0 else 1
    useful = effort * (1.0 - m.ripple[0] * math.sin(m.ripple[1] * position + m.ripple[2]))
    load = m.constant + m.stiffness * position
    load += m.cogging[0] * math.sin(m.cogging[1] * position + m.cogging[2])
    load += m.gravity[0] * math.sin(m.gravity[1] * position + m.gravity[2])
    load += m.sine[0] * math.sin(m.sine[1] * time + m.sine[2])
    return useful - load - m.viscous[way] * speed - level * bristle


@kernel
def _run(m, reference, wanted, noise, resolution, ticks, out):
    """Rows of `out`: position, speed, effort applied before the gain; a row a tick of the loop."""
    h = STEP_S
    position, speed, bristle = reference[0], 0.0, 0.0
    integral, acceleration = 0.0, 0.0
    commands = np.zeros(m.delay_steps + 1)
    last, before = position, position
    period = m.control_steps * h
    count = 0
    command = 0.0
    for tick in range(ticks):
        seen = position + noise[tick]
        if resolution > 0.0:
            seen = resolution * math.floor(seen / resolution + 0.5)
        rate = (seen - before) / (2.0 * period)
        before, last = last, seen
        error = m.position_kp * (reference[tick] - seen) + wanted[tick] - rate
        summed = integral + error * period
        command = m.speed_kp * error + m.speed_ki * summed
        if abs(command) > m.limit:
            command = math.copysign(m.limit, command)
        else:
            integral = summed
        out[tick, 0], out[tick, 1], out[tick, 2], out[tick, 3] = seen, speed, command, position
        for _ in range(m.control_steps):
            commands[count % commands.shape[0]] = command
            effort = m.gain * commands[(count + 1) % commands.shape[0]]
            count += 1
            time = count * h
            level = _level(m, time, position, speed, m.inertia * acceleration + m.constant)
            if level > 0.0:
                # The bristle at its own pace: exact over the step for a speed that stays.
                way = 1.0 if speed > 0.0 else -1.0
                fade = math.exp(-abs(speed) * h / m.presliding)
                bristle = way + (bristle - way) * fade if speed != 0.0 else bristle
            first = _net(m, time, position, speed, effort, bristle, level) / m.inertia
            guess = speed + h * first
            place = position + 0.5 * h * (speed + guess)
            second = _net(m, time + h, place, guess, effort, bristle, level) / m.inertia
            acceleration = 0.5 * (first + second)
            position += h * speed + 0.5 * h * h * acceleration
            speed += h * acceleration


def run(
    truth: Truth,
    reference: FloatArray,
    wanted: FloatArray,
    noise: FloatArray,
    resolution: float,
) -> FloatArray:
    """float64[n, 4], a row a tick of the loop: position seen, speed, command, true position.

    reference, wanted: position and speed asked for at each tick. noise: of the encoder, seen by the
    loop too. The effort that acts is `gain` times the command.
    """
    out = np.empty((reference.size, 4))
    _run(truth, reference, wanted, noise, resolution, reference.size, out)
    return out
