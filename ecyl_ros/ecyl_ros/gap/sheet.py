"""The data sheet as a distribution: constants that may lie off their nominal values, and its price.

A constant s of nominal value s0 and tolerance t (the half width that holds 95 % of sound machines)
is known as a normal distribution of standard deviation t / 2. Its *pull* is (s - s0) / t: 1 stands
at the edge of the sheet. Pulls are fitted beside every candidate, and cost (2 pull)^2 each, what
they cost in the logarithm of the distribution, twice over.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..drive.parameters import DriveParameters, leaf_fields
from ..drive.tolerances import constants_of, half_widths
from ..effects.catalogue import CATALOGUE

FloatArray = NDArray[np.float64]

# Independent pieces of evidence in a second of recording. What a model of slightly another form
# leaves is coloured: its samples say the same thing many times over, and no more than this many
# different ones. Calibrated with the sealed study: the square of a misfit that falls by 4 %, the
# least that an effect has to take off, is then worth as much as a constant at twice its tolerance.
EVIDENCE_PER_S = 25.0
_LEAST_SHARE = 0.02  # of its nominal value: no constant of a drive is fitted to 0 or below
_FAR = 50.0  # tolerances that a pull may reach


@dataclass(frozen=True, eq=False)
class Sheet:
    """The uncertain constants of a drive.

    Attributes:
        keys: dotted names as in drive files. units: SI. nominal, tolerance: float64[k].
        evidence: independent pieces of evidence that a price is weighed against.
    """

    keys: tuple[str, ...]
    units: tuple[str, ...]
    nominal: FloatArray
    tolerance: FloatArray
    evidence: float

    @classmethod
    def of(cls, drive: DriveParameters, duration_s: float) -> Sheet:
        """The sheet of a drive, to be weighed against a recording of `duration_s`."""
        nominal = constants_of(drive)
        widths = half_widths(nominal, drive.tolerances)
        keys = tuple(key for key, width in widths.items() if width > 0.0)
        leaves = leaf_fields()
        return cls(
            keys,
            tuple(leaves[key].metadata["unit"] for key in keys),
            np.array([nominal[key] for key in keys]),
            np.array([widths[key] for key in keys]),
            EVIDENCE_PER_S * duration_s,
        )

    def __len__(self) -> int:
        return len(self.keys)

    @property
    def at_nominal(self) -> FloatArray:
        """Pulls of the nominal values: zeros."""
        return np.zeros(len(self.keys))

    def constants(self, pulls: FloatArray) -> dict[str, float]:
        """Values of the constants by key; those at their nominal values are left out."""
        return {
            key: float(value + width * pull)
            for key, value, width, pull in zip(
                self.keys, self.nominal, self.tolerance, pulls, strict=True
            )
            if pull != 0.0
        }

    def bounds(self) -> tuple[FloatArray, FloatArray]:
        """(lowest, highest) pulls that a fit may reach: no constant changes its sign."""
        room = (1.0 - _LEAST_SHARE) * np.abs(self.nominal) / self.tolerance
        low = np.where(self.nominal > 0.0, -np.minimum(room, _FAR), -_FAR)
        high = np.where(self.nominal < 0.0, np.minimum(room, _FAR), _FAR)
        return low, high

    def price(self, pulls: FloatArray) -> float:
        """What leaving the sheet costs: the sum of (2 pull)^2."""
        return float(4.0 * pulls @ pulls)

    def priced(self, cost: float, pulls: FloatArray) -> float:
        """A mean square, raised by the price of its pulls.

        With the level of what is left unknown, the logarithm of a mean square counts as many times
        as there are pieces of evidence; the price adds to it.
        """
        return cost * math.exp(min(self.price(pulls) / self.evidence, 100.0))

    def free(self, effects: Collection[str]) -> NDArray[np.bool_]:
        """Constants that are fitted beside `effects`: those that none of them stands for, bool[k]."""
        taken = {CATALOGUE[name].constant for name in effects}
        return np.array([key not in taken for key in self.keys], dtype=bool)

    def pulled_to(self, effect: str, values: Mapping[str, float], drive: DriveParameters) -> FloatArray:
        """The pull, float64[k], that makes of the sheet what a constant's effect makes of it.

        Zeros where the effect stands for no uncertain constant. drive: the nominal one.
        """
        pulls = self.at_nominal
        row = self.index(CATALOGUE[effect].constant)
        if row is not None:
            value = values[CATALOGUE[effect].parameters[0].name]
            pulls[row] = (value - CATALOGUE[effect].neutral(drive)) / self.tolerance[row]
        return pulls

    def index(self, key: str | None) -> int | None:
        """Where a constant stands among the uncertain ones; None where it is not one of them."""
        return self.keys.index(key) if key in self.keys else None

