"""One parameter of an effect as a fit sees it."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from ...effects.catalogue import CATALOGUE
from ...effects.effect import Quantity

PHASE = "phase_rad"
_REACH = 60.0  # a fit may change a positive parameter by this factor either way


@dataclass(frozen=True)
class Coordinate:
    """One fitted parameter: in logarithms where it cannot change sign, else over a scale."""

    effect: str
    quantity: Quantity
    logarithmic: bool
    scale: float
    low: float
    high: float

    @classmethod
    def around(cls, effect: str, quantity: Quantity, value: float) -> Coordinate:
        """The coordinate for a fit that starts at `value`."""
        if quantity.low >= 0.0 and value > 0.0:
            low = math.log(max(quantity.low, value / _REACH, 1e-300))
            high = math.log(min(quantity.high, value * _REACH))
            return cls(effect, quantity, True, 1.0, low, high)
        scale = 1.0 if quantity.unit == "rad" else max(abs(value), 1e-9)
        return cls(effect, quantity, False, scale, quantity.low / scale, quantity.high / scale)

    @property
    def fineness(self) -> float:
        """Share of the common difference that suits this parameter.

        Over many periods a small change of order or frequency is a large change of phase.
        """
        counted = self.quantity.unit in ("1", "Hz") and not self.quantity.nuisance
        return 0.02 if counted and self.logarithmic else 1.0

    def of(self, value: float) -> float:
        """Coordinate of a value."""
        return math.log(max(value, 1e-300)) if self.logarithmic else value / self.scale

    def inward(self, value: float) -> float:
        """Coordinate of a value, kept a little off the bounds."""
        raw = self.of(value)
        margin = 1e-6 * max(1.0, min(abs(self.low), abs(self.high)))
        return min(max(raw, self.low + margin), self.high - margin)

    def outward(self, coordinate: float) -> float:
        """Value of a coordinate."""
        if self.logarithmic:
            return math.exp(coordinate)
        return coordinate * self.scale


def is_phase(parameter: str) -> bool:
    """Whether a parameter is a phase: of the first recording, or of a further one of several."""
    return parameter.partition("@")[0] == PHASE


def phase_in(number: int) -> str:
    """What the phase in one of several recordings is called, from 0."""
    return f"{PHASE}@{number}" if number else PHASE


def later(values: Mapping[str, float], by: float) -> dict[str, float]:
    """A periodic effect's parameters with all its phases turned by so much, rad."""
    return {key: value + by if is_phase(key) else value for key, value in values.items()}


def quantities(effect: str, parameters: Iterable[str]) -> list[Quantity]:
    """What the parameters of a fit are; `phase_rad@1` is the phase in the second recording."""
    known = {one.name: one for one in CATALOGUE[effect].parameters}
    return [dataclasses.replace(known[key.partition("@")[0]], name=key) for key in parameters]
