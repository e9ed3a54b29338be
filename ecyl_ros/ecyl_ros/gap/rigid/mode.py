"""What a mode beyond the compared band does within it: no drive is rigid for every frequency.

The encoder of a drive of two masses, joined by a stiffness, answers an effort like one mass, times
(1 + s^2 / w_a^2) / (1 + s^2 / w_r^2) at the motor, where w_r is the resonance and w_a the
antiresonance, and without the latter at the load. Below the resonance that is 1 + k s^2.
An effort that jumps, as of a relay or in a step test, is full of s^2, and it jumps where and when
the motion turns: without k, what depends on position or time would be found in its place.
"""

from __future__ import annotations

import math

import numpy as np

from ...effects import actuation_delay
from ...effects.term import Term
from .jumps import jumping
from .motion import Motion

MODE = "mode"  # key of its term
_LOWEST = 0.5  # of the band: an antiresonance below it is no rigid drive's
_FEWEST = 4  # jumps that tell


def mode(motion: Motion, known_s: float) -> Term | None:
    """The curvature of what jumps in the effort; its coefficient is k, s^2, of either sign.

    None where too little does. The rest of the effort is left aside: it is slow, and its noise is
    the noise of what is left of the effort, so that k would be what cancels that.

    known_s: what the recorded effort is ahead of the motion by, as far as it is taken out.
    """
    effort = motion.effort
    steps = jumping(effort, motion.usable)
    if int(np.sum(np.diff(steps.astype(np.int8), prepend=0) == 1)) < _FEWEST:
        return None
    jumps = np.concatenate([[0.0], np.cumsum(np.where(steps, np.diff(effort), 0.0))])
    curved = motion.derived(jumps, 2, known_s)
    return Term(
        effect=actuation_delay.EFFECT.name,
        key=MODE,
        columns=curved[None],
        parameters=lambda c: (("squared_s2", "s^2", float(c[0])),),
        values=lambda c: {},
        low=(-math.inf,),
        of_effort=False,
    )


def largest(motion: Motion) -> float:
    """Half width of k, s^2: the resonance is beyond the band, the antiresonance beyond half."""
    return (_LOWEST * math.tau * motion.bandwidth_hz) ** -2
