"""A rigid machine moved by its effort: one inertia, friction that sticks, what acts over position.

    M dv/dt = e (1 - shares(q)) - friction - viscous v - stiffness q - constant - loads(t, q)

with a sum over the effects at work at each port (`effects.rigid_ports`), and a learned law among
the loads or in the friction (`rigid.law`).

A step takes position and viscous friction at its middle (second order), Coulomb friction as a set:
the speed comes to nought within a step where friction is enough to stop it, and stays there while
friction holds the rest (time stepping after Moreau, "Unilateral contact and dry friction in finite
freedom dynamics", 1988), so that nothing has to be softened and no step is stiff.
"""

from __future__ import annotations

import math

import numpy as np

from ...effects.rigid_ports import rigid_level, rigid_load, rigid_share
from ..compiled import kernel
from .law import FRICTION, TORQUE, rigid_law

_NEXT_TO_NOUGHT = 1e-300  # speed of a motion that is about to begin


@kernel
def _level(p, time, position, speed, acceleration, way, memory):
    """Friction level against motion to `way` (1, -1), viscous part left out; never below nought."""
    level = p.coulomb_forwards if way > 0.0 else p.coulomb_backwards
    for row in range(p.levels.shape[0]):
        v = p.levels[row]
        level += rigid_level(int(v[0]), v[1:], time, position, speed, acceleration)
    if p.law[0].learned_port == FRICTION:
        moving = speed if speed != 0.0 else way * _NEXT_TO_NOUGHT
        level += rigid_law(p.law[0], time, position, moving, memory[0], memory[1])
    return max(level, 0.0)


@kernel
def step(p, time, position, speed, acceleration, effort, pushed, memory, h):
    """Position, speed and acceleration after `h` s under an effort that stays.

    time, position, speed: at the beginning. pushed: load beyond the model's, against positive
    motion. acceleration: of the last step. memory: heat and travel, for a law of theirs.
    """
    middle = position + 0.5 * h * speed
    half = time + 0.5 * h
    share = 1.0
    for row in range(p.shares.shape[0]):
        v = p.shares[row]
        share -= rigid_share(int(v[0]), v[1:], middle)
    load = p.constant + p.stiffness * middle + pushed
    for row in range(p.loads.shape[0]):
        v = p.loads[row]
        load += rigid_load(int(v[0]), v[1:], half, middle)
    if p.law[0].learned_port == TORQUE:
        load -= rigid_law(p.law[0], half, middle, speed, memory[0], memory[1])
    drive = effort * share - load
    left = h
    new = speed
    if speed != 0.0:
        way = math.copysign(1.0, speed)
        viscous = p.viscous_forwards if way > 0.0 else p.viscous_backwards
        level = _level(p, half, middle, speed, acceleration, way, memory)
        rate = p.inertia / h
        new = ((rate - 0.5 * viscous) * speed + drive - way * level) / (rate + 0.5 * viscous)
        if new * way > 0.0:
            return position + 0.5 * h * (speed + new), new, (new - speed) / h
        # It stops within the step, and what is left of the step begins at rest.
        left = h * (1.0 - speed / (speed - new))
        middle = position + 0.5 * (h - left) * speed
        new = 0.0
    else:
        middle = position
    way = math.copysign(1.0, drive)
    level = _level(p, half, middle, 0.0, 0.0, way, memory)
    if abs(drive) > level and left > 0.0:
        viscous = p.viscous_forwards if way > 0.0 else p.viscous_backwards
        new = (drive - way * level) / (p.inertia / left + 0.5 * viscous)
    stopped = position + 0.5 * (h - left) * speed
    return stopped + 0.5 * left * new, new, (new - speed) / h


def along(p, time, position, speed, effort, pushed, memory, h):
    """Positions and speeds at the beginning of each step under efforts given per step, both [n].

    pushed: [n]. memory: [n, 2], of a law.
    """
    positions, speeds = np.empty(len(effort)), np.empty(len(effort))
    _along(p, time, position, speed, effort, pushed, memory, h, positions, speeds)
    return positions, speeds


@kernel
def _along(p, time, position, speed, effort, pushed, memory, h, positions, speeds):
    acceleration = 0.0
    for index in range(effort.shape[0]):
        positions[index], speeds[index] = position, speed
        position, speed, acceleration = step(
            p,
            time + index * h,
            position,
            speed,
            acceleration,
            effort[index],
            pushed[index],
            (memory[index, 0], memory[index, 1]),
            h,
        )
