"""An effort that shows nothing of the motion: at its limit, constant, or not what moves the output.

Its mean is no load then, nor friction: a machine that speeds up and slows down has an inertia, and
rubs. One steady effort and one even acceleration are also an inertia without any friction.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from ...drive.rigid.model import Model
from ...effects.term import Interval, Term
from .motion import Motion
from .noise import acceleration_noise

_ACCELERATES = 3.0  # times its noise: then an acceleration is seen


def shows_nothing(motion: Motion, model: Model, spans: Iterable[tuple[Term, Interval]]) -> bool:
    """Whether the effort shows neither inertia nor friction, nor anything else that goes with a
    motion that speeds up and slows down.

    model: what the file states; where that is an inertia or friction, it says what has to show.
    spans: all that was fitted but a steady effort, and that is shown beside it, each with the
    interval of its first parameter.
    """
    if model.inertia is not None or any(model.viscous) or any(model.coulomb):
        return False
    acceleration = float(np.std(motion.acceleration[motion.usable]))
    if acceleration < _ACCELERATES * acceleration_noise(motion):
        return False
    return not any(span.low > 0.0 or (span.high < 0.0 and not one.inertia) for one, span in spans)


def nothing_shown(motion: Motion) -> str:
    """That in words."""
    return (
        f"the {motion.effort_name} shows nothing of the motion, neither inertia nor friction, as "
        "at its limit, where it does not change, or where something else moves the output"
    )
