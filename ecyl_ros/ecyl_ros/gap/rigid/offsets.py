"""What a loop's integral became while nothing was recorded: an effort's offset after each gap."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np

from ...effects.along import Along
from ...recording.runs import runs_of
from ..diagnosis import FloatArray
from .motion import Motion

_SHORTEST_S = 0.5  # of a run of samples that an offset is told from


def without_offsets(motion: Motion, along: Along) -> Motion:
    """The motion with its effort freed of offsets that begin at gaps, where a loop asks for it.

    By regression on what any machine asks for; the first run of a recording keeps its own.
    """
    machine = along.machine
    if machine.actuation != "loop" or not machine.speed_ki:
        return motion
    runs = runs_of(motion.usable)
    runs = runs[runs[:, 1] - runs[:, 0] >= _SHORTEST_S * motion.rate_hz]
    made = list[FloatArray]()
    for part in motion.parts:
        own = runs[(runs[:, 0] >= part.start) & (runs[:, 0] < part.stop), 0].tolist()
        for begin, end in pairwise([*own[1:], part.stop]):
            made.append(np.zeros(motion.time_s.size))
            made[-1][begin:end] = 1.0
    if not made:
        return motion
    steps = np.stack(made)
    smooth = along.smooth()
    columns = motion.filtered(np.concatenate([smooth, steps]))
    rows = motion.usable[motion.rows]
    scale = np.sqrt(np.mean(columns[:, rows] ** 2, axis=1)) + 1e-300
    target = motion.filtered(motion.effort)[rows]
    found = np.linalg.lstsq((columns[:, rows] / scale[:, None]).T, target, rcond=1e-10)[0] / scale
    return replace(motion, effort=motion.effort - found[len(smooth) :] @ steps)
