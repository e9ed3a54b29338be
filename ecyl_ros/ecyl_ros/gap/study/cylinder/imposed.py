"""How an effect is drawn and put on a stand-in; one object per effect."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ....drive.parameters import DriveParameters
from .physics import Physics

Values = dict[str, float]


@dataclass(frozen=True)
class Scale:
    """Peaks of what the nominal drive does on a case's reference; sizes are drawn against them."""

    torque_nm: float
    current_a: float
    voltage_v: float
    speed_rad_s: float
    stroke_m: float  # largest distance from the start

    def force_n(self, share: float, drive: DriveParameters) -> float:
        """A force on the rod that asks for `share` of the peak torque, N."""
        return share * self.torque_nm / drive.transmission.rod_per_rotor


@dataclass(frozen=True)
class Draw:
    """What an effect's values are drawn from."""

    rng: np.random.Generator
    drive: DriveParameters
    scale: Scale

    def within(self, low: float, high: float) -> float:
        """Uniform between two values."""
        return float(self.rng.uniform(low, high))

    def one_of(self, *values: float) -> float:
        """One of the values."""
        return float(self.rng.choice(values))

    def torque(self, low: float, high: float) -> float:
        """A torque between two shares of the peak torque, N m."""
        return self.within(low, high) * self.scale.torque_nm

    def viscous(self, low: float, high: float) -> float:
        """A viscous friction whose torque at peak speed lies in these shares of the peak torque."""
        return self.torque(low, high) / self.scale.speed_rad_s

    def force(self, low: float, high: float) -> float:
        """A force on the rod between two shares of the peak torque, N."""
        return self.scale.force_n(self.within(low, high), self.drive)

    def side(self) -> float:
        """1 or -1."""
        return self.one_of(-1.0, 1.0)

    def place(self) -> float:
        """A place the motion passes often, as rod position, m."""
        return self.within(-0.4, 0.4) * self.scale.stroke_m


@dataclass(frozen=True)
class Imposed:
    """One effect as the study imposes it.

    Attributes:
        name: of the effect; `x_...` is outside every catalogue.
        block: where it acts.
        draw: values of its parameters.
        impose: puts them on a machine, in place. phases: float64[2], rad, hidden.
        akin: catalogue effects that name the same cause in a simpler form; naming them is no error.
        twin: what a catalogue larger than the contract's calls this very cause.
    """

    name: str
    block: str
    draw: Callable[[Draw], Values]
    impose: Callable[[Physics, Values, np.ndarray], None]
    akin: frozenset[str] = frozenset()
    twin: str | None = None
