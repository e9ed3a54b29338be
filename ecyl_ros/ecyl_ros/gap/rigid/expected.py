"""What every machine has, though its file may leave it out: it takes less to be believed.

The scale of `Effect.rarity` begins with what most machines have, a third for each step. No machine
is without friction: a file that states none has left it to be found, two steps before that.
"""

from __future__ import annotations

import math

from ...effects.along import Along
from ..judge.verdict import RARER

STEPS = 2


def before(along: Along, effect: str) -> int:
    """Steps of rarity that an effect comes before where `Effect.rarity` puts it."""
    return STEPS if effect in along.unstated else 0


def log_odds(along: Along, effect: str) -> float:
    """The same as a logarithm of odds."""
    return -before(along, effect) * math.log(RARER)
