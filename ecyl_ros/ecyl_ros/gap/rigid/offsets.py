"""What a loop's integral became while nothing was recorded: an effort's offset after each gap."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np

from ...arrays import FloatArray
from ...effects.along import Along
from ...effects.term import Term
from ...recording.runs import runs_of
from .balance import Balance
from .motion import Motion, settling
from .rest import moving

_SHORTEST_S = 0.5  # of a run of samples that an offset is told from


def without_offsets(motion: Motion, along: Along) -> Motion:
    """The motion with its effort freed of offsets that begin at gaps, where a loop asks for it.

    By robust regression on what any machine asks for while it moves, for at rest friction holds
    what it must; the first run of a recording keeps its own.
    """
    machine = along.machine
    if machine.actuation != "loop" or not machine.speed_ki:
        return motion
    steps = _steps(motion)
    if not steps.size:
        return motion
    smooth = along.smooth()
    columns = np.concatenate([smooth, steps])
    every = Term(
        effect="",
        key="smooth and offsets",
        columns=columns,
        parameters=lambda c: (),
        values=lambda c: {},
        low=(-math.inf,) * len(columns),
    )
    balance = Balance(motion, np.zeros_like(motion.effort), along.model)
    found = balance.fit([every], moving(balance.usable, motion, along)).coefficients
    return replace(motion, effort=motion.effort - found[len(smooth) :] @ steps)


def _steps(motion: Motion) -> FloatArray:
    """A step for each gap, float64[gaps, n]."""
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
    return np.array(made)
