"""Where a reference stands: a dead band shows there, an axis that is only slow does not.

Behind a dead band the output stays half its width short of where it is asked to be, from either
side, however long it is asked. What comes nearer than that before the reference moves on has none
that wide, whether it stands yet or not.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..arrays import BoolArray, FloatArray
from ..recording.runs import runs_of
from .rigid.motion import Motion

_STOPS = 2  # from either side
_FEWEST = 3  # samples of a reference that stands
_MOVED = 3.0  # resolutions that the output moves to a stop, at the least


class Stops(NamedTuple):
    """The widest dead band that stops allow, and half of its 95 % interval."""

    width: float
    half: float


def stops_of(
    reference: FloatArray, position: FloatArray, usable: BoolArray, resolution: float
) -> Stops | None:
    """What the last instants before a reference moves on allow; None with fewer than two of them
    from either side.

    reference, position: float64[n]. usable: bool[n]. resolution: of the position.
    """
    same = np.abs(np.diff(reference)) <= 1e-6 * float(np.ptp(reference))
    short: dict[bool, list[float]] = {True: [], False: []}
    for begin, end in runs_of(same).tolist():
        moved = float(position[end] - position[begin])
        if usable[end] and end - begin >= _FEWEST and abs(moved) > _MOVED * resolution:
            short[moved > 0.0].append(float(reference[end] - position[end]))
    up, down = (np.array(short[one]) for one in (True, False))
    if min(up.size, down.size) < _STOPS:
        return None
    spread = math.sqrt(sum(float(np.var(one, ddof=1)) / one.size for one in (up, down)))
    return Stops(max(float(up.mean() - down.mean()), 0.0), 2.0 * spread + resolution)


def said_of_stops(motion: Motion, unit: str) -> str:
    """Why the output is behind where its stops allow no dead band as wide as its motion has it."""
    speed = float(np.quantile(np.abs(motion.velocity[motion.usable]), 0.99))
    return (
        "where the reference stands the output comes nearer to it, from both sides, than the dead "
        "band that would fit its motion: it has none wider than is told here. On its way it is "
        f"behind for another reason, such as a speed of no more than {speed:.3g} {unit}/s; the "
        "drive's own demand in place of a reference that jumps would tell more"
    )
