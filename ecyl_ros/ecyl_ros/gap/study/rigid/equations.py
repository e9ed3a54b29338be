"""Rigid drives that a diagnosis has not seen: other friction, other steps, a loop of its own.

Nothing here is shared with what is fitted. Friction is LuGre's (Canudas de Wit, Olsson, Astrom,
Lischinsky, "A new model for control of systems with friction", 1995): bristles that bend over a
presliding range, a level that falls towards its Coulomb value with speed. A jam sets in along a
raised cosine; a winding fed with voltage has its current's lag and its back-EMF. The speed is
stepped by Heun's method every 50 us, bristles and current by their exact solutions.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ....arrays import FloatArray
from ....drive.compiled import kernel

STEP_S = 5e-5
NONE = (0.0, 0.0, 0.0)  # of what has three numbers


class Truth(NamedTuple):
    """A machine and its loop; SI of the output, effort in N or N m.

    viscous, coulomb: forwards, backwards. static, stribeck: level at rest beyond Coulomb, and the
    speed over which it falls. drift_per_s: of the friction level. carried: level over the load
    carried. jam: level, middle, width. cogging, gravity, ripple: amplitude (of the ripple a share),
    rad per position, phase. sine: amplitude, rad/s, phase. presliding: travel. delay_steps: steps
    of `STEP_S` from command to effort. gain: true effort per what is recorded as effort.
    position_kp, speed_kp, speed_ki, limit: of the loop, in what is recorded as effort.
    control_steps: steps of a tick. winding: resistance, back-EMF per speed, L/R of a drive
    commanded by voltage, effort then `gain` per ampere. bristle_ratio: damping ratio of the bent
    bristles with the inertia they hold; it fades over bristle_fade, a speed.
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
    winding: tuple[float, float, float] = NONE
    bristle_ratio: float = 0.0
    bristle_fade: float = 1.0


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
def _external(m, position):
    """Load that acts on the output from outside."""
    weight = m.gravity[0] * math.sin(m.gravity[1] * position + m.gravity[2])
    return m.constant + m.stiffness * position + weight


@kernel
def _net(m, time, position, speed, effort, friction, coupling):
    """Force that accelerates: effort less all that opposes."""
    way = 0 if speed >= 0.0 else 1
    useful = effort * (1.0 - m.ripple[0] * math.sin(m.ripple[1] * position + m.ripple[2]))
    load = _external(m, position)
    load += m.cogging[0] * math.sin(m.cogging[1] * position + m.cogging[2])
    load += m.sine[0] * math.sin(m.sine[1] * time + m.sine[2])
    return useful - load - m.viscous[way] * speed - friction - coupling


@kernel
def _bristle_stiffness(m):
    """Effort per travel of the bent bristles: what they carry at most over the presliding range."""
    level = 0.5 * (m.coulomb[0] + m.coulomb[1]) + m.static + m.jam[0]
    return (level if level > 0.0 else 1.0) / m.presliding


@kernel
def _friction(bristle, speed, level, stiffness, damping, m):
    """Effort of bristles that are bent by `bristle`, LuGre."""
    if level <= 0.0:
        return 0.0
    fast = speed / m.bristle_fade
    rate = speed - abs(speed) * bristle * stiffness / level
    return stiffness * bristle + damping / (1.0 + fast * fast) * rate


@kernel
def _run(m, reference, wanted, noise, resolution, coupling, commands, out):
    """Rows of `out`: see `run`; a row a tick of the loop.

    commands: scratch, float64[delay in steps + 1].
    """
    h = STEP_S
    position, speed, bristle, current = reference[0], 0.0, 0.0, 0.0
    integral, acceleration = 0.0, 0.0
    last, before = position, position
    period = m.control_steps * h
    stiffness = _bristle_stiffness(m)
    damping = 2.0 * m.bristle_ratio * math.sqrt(stiffness * m.inertia)
    settles = math.exp(-h / m.winding[2]) if m.winding[2] > 0.0 else 0.0
    count = 0
    command = 0.0
    for tick in range(out.shape[0]):
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
        row = out[tick]
        row[0], row[1], row[2], row[3] = seen, speed, command, position
        row[4], row[5] = acceleration, current
        for _ in range(m.control_steps):
            commands[count % commands.shape[0]] = command
            asked = commands[(count + 1) % commands.shape[0]]
            if m.winding[0] > 0.0:
                end = (asked - m.winding[1] * speed) / m.winding[0]
                current = end + (current - end) * settles
                effort = m.gain * current
            else:
                effort = m.gain * asked
            count += 1
            time = count * h
            carried = m.inertia * acceleration + _external(m, position)
            level = _level(m, time, position, speed, carried)
            if level > 0.0 and speed != 0.0:
                # Bristles at their own pace: exact over the step for a speed that stays.
                end = math.copysign(level / stiffness, speed)
                bristle = end + (bristle - end) * math.exp(-abs(speed) * h * stiffness / level)
            rub = _friction(bristle, speed, level, stiffness, damping, m)
            first = _net(m, time, position, speed, effort, rub, coupling[tick]) / m.inertia
            guess = speed + h * first
            place = position + 0.5 * h * (speed + guess)
            rub = _friction(bristle, guess, level, stiffness, damping, m)
            second = _net(m, time + h, place, guess, effort, rub, coupling[tick]) / m.inertia
            acceleration = 0.5 * (first + second)
            position += h * speed + 0.5 * h * h * acceleration
            speed += h * acceleration


def run(
    truth: Truth,
    reference: FloatArray,
    wanted: FloatArray,
    noise: FloatArray,
    resolution: float,
    coupling: FloatArray | None = None,
) -> FloatArray:
    """float64[n, 6], a row a tick of the loop.

    Columns: position seen, speed, command, true position, acceleration, current of the winding.

    reference, wanted: position and speed asked for at each tick. noise: of the encoder, seen by the
    loop too. resolution: of the encoder as the loop sees it, 0 for none. coupling: effort that
    another axis asks for at each tick. The effort that acts is `gain` times the command, or times
    the current that it drives through the winding.
    """
    out = np.empty((reference.size, 6))
    other = np.zeros(reference.size) if coupling is None else coupling
    commands = np.zeros(truth.delay_steps + 1)
    _run(truth, reference, wanted, noise, resolution, other, commands, out)
    return out
