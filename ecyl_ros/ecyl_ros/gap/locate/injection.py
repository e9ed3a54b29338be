"""On which side of the clearance torque acts that the model does not explain.

The torque balance in contact tells how much torque is missing, not whether the rotor or the load
feels it. Put on the right side in a replay it brings every signal nearer; on the wrong side it
sends the load to the wrong flank, which the twist between rotor and rod shows.
"""

from __future__ import annotations

import math

import numpy as np

from ...arrays import FloatArray
from ..fit.robust import cost
from ..replay.evidence import missing_torque
from ..replay.replay import Replay

_ROUNDS = 4  # of putting on what is still missing
_ROTOR_BY_TWIST = 3.0  # times as wrong a twist with the torque on the load
_LOAD_BY_TWIST = 0.87
_CLEARLY = 0.04  # difference of the misfits that says anything


def acts_on_load(replay: Replay) -> bool | None:
    """Whether the missing torque acts on the load, not on the rotor.

    None where rotor position, speed, current or rod position is not recorded, or neither side
    is clearly better.
    """
    names = {one.name for one in replay.signals}
    if not {"rotor_position", "rotor_velocity", "current_q", "rod_position"} <= names:
        return None
    (on_rotor, rotor_twist), (on_load, load_twist) = (_pushed(replay, side) for side in range(2))
    twist = load_twist / rotor_twist
    if twist > _ROTOR_BY_TWIST or twist < _LOAD_BY_TWIST:
        return twist < 1.0
    if abs(on_load - on_rotor) < _CLEARLY * min(on_load, on_rotor):
        return None
    return on_load < on_rotor


def _pushed(replay: Replay, side: int) -> tuple[float, float]:
    """What is left with the missing torque on a side (0 rotor, 1 load): robust misfit, twist.

    The twist is the RMS of what is left of it, over its noise floor.
    """
    torque = np.zeros((2, len(replay.time_s)))
    best = (math.inf, math.inf)
    for _ in range(_ROUNDS):
        columns = replay.full({}, torque)
        gap = replay.gap_of(columns[[one.column for one in replay.signals]])
        best = min(best, (math.sqrt(cost(gap, replay.usable)), _twist(replay, gap)))
        torque[side] += missing_torque(replay, columns)
    return best


def _twist(replay: Replay, gap: FloatArray) -> float:
    index = {one.name: row for row, one in enumerate(replay.signals)}
    rotor, rod = index["rotor_position"], index["rod_position"]
    ratio = replay.drive.transmission.rod_per_rotor
    rod_floor = replay.floor[rod] / ratio
    twist = gap[rod] * rod_floor - gap[rotor] * replay.floor[rotor]
    floor = math.hypot(rod_floor, float(replay.floor[rotor]))
    return float(np.sqrt(np.mean(twist[replay.usable] ** 2))) / floor
