"""What a loop's integral became while nothing was recorded: an effort's offset after each gap."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...effects.along import Along
from ...recording.runs import runs_of
from .motion import Motion

_SHORTEST_S = 0.5  # of a run of samples that an offset is told from


def without_offsets(motion: Motion, along: Along) -> Motion:
    """The motion with its effort freed of offsets that begin at gaps, where a loop asks for it.

    By regression on what any machine asks for; the first run keeps its own.
    """
    machine = along.machine
    if machine.actuation != "loop" or not machine.speed_ki:
        return motion
    runs = runs_of(motion.usable)
    runs = runs[runs[:, 1] - runs[:, 0] >= _SHORTEST_S * motion.rate_hz]
    if runs.shape[0] < 2:
        return motion
    begins = [0, *runs[1:, 0].tolist()]
    ends = [*begins[1:], motion.time_s.size]
    steps = np.zeros((runs.shape[0] - 1, motion.time_s.size))
    for row, begin, end in zip(steps, begins[1:], ends[1:], strict=True):
        row[begin:end] = 1.0
    smooth = along.smooth()
    columns = motion.filtered(np.concatenate([smooth, steps]))
    rows = motion.usable[motion.rows]
    scale = np.sqrt(np.mean(columns[:, rows] ** 2, axis=1)) + 1e-300
    target = motion.filtered(motion.effort)[rows]
    found = np.linalg.lstsq((columns[:, rows] / scale[:, None]).T, target, rcond=1e-10)[0] / scale
    return replace(motion, effort=motion.effort - found[len(smooth) :] @ steps)
