"""Every effect that the study puts on a cylinder, by name."""

from __future__ import annotations

from .imposed import Imposed
from .inside import INSIDE
from .outside import OUTSIDE
from .unnamed import UNNAMED

EFFECTS: dict[str, Imposed] = (
    INSIDE | OUTSIDE | {name: one.imposed for name, one in UNNAMED.items()}
)

# Two forms of one friction: a pair of them is one friction of the second form.
SAME_CAUSE = ({"rotor_coulomb_friction", "stribeck_friction"},)
