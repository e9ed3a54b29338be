"""A law as it is tried, and as it comes out of a regression."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

from ...arrays import FloatArray
from ...drive.law import Law, order_of
from .axis import Axis
from .regress import Regression

COARSE = 12  # times a turn that the table of a whole turn holds, at four places each
FINEST = 96  # times a turn, as the catalogue's own waves


class Trial(NamedTuple):
    """Variables to be tried: of the load or the rotor, with a time constant of heat, s, or of what
    repeats itself `order` times a turn."""

    of: tuple[str, ...]
    on_load: bool = False
    heat_s: float = 0.0
    order: int = 1


@dataclass(frozen=True, eq=False)
class Guess:
    """A law at a kind of port, regressed.

    Attributes:
        kind: `torque` or `friction` (on rotor or load), or a port. of: the variables.
        axes: of the table. time_constant_s: of heat.
        found: the regression. on_load: whether the variables are the load's.
    """

    kind: str
    of: tuple[str, ...]
    axes: tuple[Axis, ...]
    time_constant_s: float
    found: Regression
    on_load: bool = False

    @property
    def order(self) -> int:
        """How often it repeats itself in a turn; 1 where it has no angle."""
        return max(
            (order_of(name, axis.period) for name, axis in zip(self.of, self.axes, strict=True)),
            default=1,
        )

    @property
    def looked_at(self) -> int:
        """Orders that it was chosen from."""
        return FINEST - COARSE if self.order > 1 else 0

    def with_values(self, values: FloatArray) -> Guess:
        """The same with other values."""
        return replace(self, found=replace(self.found, values=values))

    def law(self, port: str, values: FloatArray | None = None) -> Law:
        """As it is played at a port."""
        given = self.found.values if values is None else values
        return Law(
            port,
            self.of,
            tuple(tuple(float(one) for one in axis.at) for axis in self.axes),
            tuple(float(one) for one in given),
            tuple(axis.period for axis in self.axes),
            self.time_constant_s if "heat" in self.of else 0.0,
        )

    @property
    def tried(self) -> Trial:
        """The trial that it came of."""
        return Trial(self.of, self.on_load, self.time_constant_s, self.order)
