"""Every effect that the study puts on a cylinder, by name."""

from __future__ import annotations

from .imposed import Imposed
from .inside import INSIDE
from .outside import OUTSIDE

EFFECTS: dict[str, Imposed] = INSIDE | OUTSIDE

# Two forms of one friction: a pair of them is one friction of the second form.
SAME_CAUSE = ({"rotor_coulomb_friction", "stribeck_friction"},)
