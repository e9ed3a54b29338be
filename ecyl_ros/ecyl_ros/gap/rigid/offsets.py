"""What a loop's integral became while nothing was recorded: an effort's offset after each gap."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np

from ...effects.along import Along
from ...recording.runs import runs_of
from ..diagnosis import FloatArray
from .motion import Motion, settling

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
    settle, index = settling(motion.rate_hz, motion.bandwidth_hz), np.arange(motion.time_s.size)
    for part in motion.parts:
        own = runs[(runs[:, 0] >= part.start) & (runs[:, 0] < part.stop)].tolist()
        for (_, last), (begin, _) in pairwise(own):
            # The effort is a straight line across the gap: so is what is taken from it.
            rise = np.interp(index, (last - 1 + settle, begin - settle), (0.0, 1.0))
            made.append(np.where(index < part.stop, rise, 0.0))
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
