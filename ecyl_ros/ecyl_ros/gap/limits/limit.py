"""What a recording could have shown: plain data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any


@dataclass(frozen=True)
class Limit:
    """The smallest size of an effect that a recording would have shown with 95 %.

    Attributes:
        effect: its name. parameter, unit: what its size is counted in.
        smallest_seen: distance from `neutral` at which it would have been seen; None where no size
            would have been.
        neutral: value of the parameter at which the effect vanishes here: 0, the nominal value of a
            constant, or the largest value that the motion asks for (of a limit).
        side: 1 where the size is counted upwards from `neutral`, -1 downwards.
        at: what else the size is stated for (an order, a frequency), by parameter.
    """

    effect: str
    parameter: str
    unit: str
    smallest_seen: float | None
    neutral: float = 0.0
    side: int = 1
    at: Mapping[str, float] = field(default_factory=dict)

    def as_json(self) -> dict[str, Any]:
        """Plain data."""
        return asdict(self)


@dataclass(frozen=True)
class Alike:
    """Two effects that a recording hardly tells apart.

    Attributes:
        effects: the one that acts, and the one that it would be taken for.
        separation: RMS over all signals, in noise floors, of what the second leaves of the first
            beside the sheet, its price included, when the first is `times` as large as the
            smallest that is seen.
        needed: the same that it takes to tell them.
    """

    effects: tuple[str, str]
    separation: float
    needed: float
    times: float

    def as_json(self) -> dict[str, Any]:
        """Plain data."""
        return {**asdict(self), "effects": list(self.effects)}
