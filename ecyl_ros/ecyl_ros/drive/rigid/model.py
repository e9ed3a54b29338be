"""What is known of a rigid machine as one model of effort: constants, and effects beyond them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

from ..law import Law

Pair = tuple[float, float]  # forwards, backwards


def plus(pair: Pair, forwards: float, backwards: float | None = None) -> Pair:
    """More by so much forwards, and backwards, where it is the same unless given."""
    return pair[0] + forwards, pair[1] + (forwards if backwards is None else backwards)


@dataclass(frozen=True)
class Acting:
    """One effect at work: its name, and its values by stem (see `effects.rigid_form`)."""

    name: str
    values: Mapping[str, float]


class Keys(NamedTuple):
    """What the keys of a drive file ask for by its own gain; 0 where they do not say."""

    inertia: float = 0.0
    viscous: float = 0.0
    coulomb: float = 0.0
    constant: float = 0.0
    stiffness: float = 0.0


@dataclass(frozen=True)
class Model:
    """The effort that a rigid machine asks for, in one unit of effort and SI of the output.

        effort(t - delay_s) = inertia a + viscous v + coulomb sign(v) + stiffness q + constant + ...

    Attributes:
        inertia: None where the file leaves it out. viscous, coulomb: forwards and backwards.
        keys: of the file's own keys alone, in N or N m. ratio: effort by the file's gain over
            effort by the true one, which an effect may tell; without a gain in the file effort as
            recorded over effort in N or N m, 0 where that is unknown. counted: effort over what the
            keys ask for, by the file's own gain, or else by `ratio`.
        shapes: effects that no constant can hold. learned: a law that has no name.
    """

    inertia: float | None
    viscous: Pair
    coulomb: Pair
    constant: float
    stiffness: float
    delay_s: float
    keys: Keys
    ratio: float
    counted: float
    shapes: tuple[Acting, ...] = ()
    learned: Law | None = None
