"""Sensor noise that depends only on seed, tick and channel.

A counter-based generator (the splitmix64 finaliser) and Box-Muller, so that the noise of a tick is
the same in any process, in any order, however often it is asked for: a node that starts late or
repeats a tick draws what the engine draws.
"""

from __future__ import annotations

import math

import numpy as np

from .compiled import kernel

_GOLDEN = np.uint64(0x9E3779B97F4A7C15)
_MIX_1 = np.uint64(0xBF58476D1CE4E5B9)
_MIX_2 = np.uint64(0x94D049BB133111EB)
_TO_UNIT = 2.0**-53


@kernel
def _mix(word):
    word = word + _GOLDEN
    word = (word ^ (word >> np.uint64(30))) * _MIX_1
    word = (word ^ (word >> np.uint64(27))) * _MIX_2
    return word ^ (word >> np.uint64(31))


@kernel
def gaussian(seed, tick, channel):
    """One standard normal number for (seed, tick, channel), all unsigned 64-bit integers."""
    base = _mix(_mix(np.uint64(seed) ^ (np.uint64(channel) << np.uint64(56))) ^ np.uint64(tick))
    u1 = (np.float64(_mix(base) >> np.uint64(11)) + 0.5) * _TO_UNIT
    u2 = (np.float64(_mix(base ^ _MIX_1) >> np.uint64(11)) + 0.5) * _TO_UNIT
    return math.sqrt(-2.0 * math.log(u1)) * math.cos(2.0 * math.pi * u2)
