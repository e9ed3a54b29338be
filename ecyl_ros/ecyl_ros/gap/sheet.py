"""The data sheet as a distribution: constants that may lie off their nominal values, and its price.

A constant s of nominal value s0 and tolerance t (half width that holds 95 % of healthy machines)
is known as log s, normally distributed about log s0 with a standard deviation of t / (2 s0): in
logarithms what scales together (a torque constant, and all inertias and frictions) lies on straight
lines. Its *pull* is log(s / s0) s0 / t, hence (s - s0) / t near the nominal value: 1 stands at the
edge of the sheet. Pulls are fitted beside every candidate, and cost (2 pull)^2 each, twice what
they subtract from the logarithm of the distribution. Whether one has left its sheet goes by
(s - s0) / t, as data sheets count, where that is more.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass

import numpy as np

from ..arrays import BoolArray, FloatArray
from ..drive.coupling import free_widths
from ..drive.parameters import DriveParameters, leaf_fields
from ..drive.tolerances import ALL, EXACT, constants_of, half_widths
from ..effects.catalogue import CATALOGUE

# Independent pieces of evidence in a second of recording. What a model of slightly another form
# leaves is coloured: its samples say the same thing many times over, and no more than this many
# different ones. Calibrated with the sealed study: the square of a misfit that falls by 4 %, the
# least that an effect has to remove, is then worth as much as a constant at twice its tolerance.
EVIDENCE_PER_S = 25.0
_DEAREST = 100.0  # price that counts
PULL_PRICE = 4.0  # of a pull, times its square: a tolerance is two standard deviations
_LEAD, _FEED = "transmission.lead", "controller.feed_scale"
_DAMPING, _DAMPING_RATIO = "transmission.contact_damping", 0.1
_FAR = 50.0  # tolerances that a pull may reach, and factor that a constant may change by


def _damping_of_steel(drive: DriveParameters) -> float:
    """Contact damping that a transmission may have of which nobody states any, N m s/rad.

    No contact of flanks is without loss: joints of steel damp their resonance by some percent.
    """
    rotor, load = drive.motor.rotor_inertia, drive.load.inertia
    reduced = rotor * load / (rotor + load)
    return 2.0 * _DAMPING_RATIO * math.sqrt(drive.transmission.stiffness[0] * reduced)


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
        stated = drive.tolerances.get(_DAMPING, drive.tolerances.get(ALL))
        if nominal[_DAMPING] == 0.0 and stated != EXACT:
            widths[_DAMPING] = max(widths[_DAMPING], _damping_of_steel(drive))
        if drive.controller.feedback == "rotor":  # which lead the controller reckons with
            widths[_FEED] = max(widths[_FEED], nominal[_FEED] * widths[_LEAD] / nominal[_LEAD])
        widths |= free_widths({key: nominal[key] for key in drive.left_out})
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

    @property
    def relative(self) -> FloatArray:
        """Tolerances as shares of the nominal values; 0 where there is none to be a share of."""
        return np.divide(
            self.tolerance,
            self.nominal,
            out=np.zeros_like(self.tolerance),
            where=self.nominal > 0.0,
        )

    def values(self, pulls: FloatArray) -> FloatArray:
        """Values of all constants, float64[k]; on a line where the nominal value is 0."""
        relative = self.relative
        on_line = self.nominal + self.tolerance * pulls
        made: FloatArray = np.where(
            relative > 0.0, self.nominal * np.exp(relative * pulls), on_line
        )
        return made

    def constants(self, pulls: FloatArray) -> dict[str, float]:
        """Values of the constants by key; those at their nominal values are left out."""
        values = self.values(pulls)
        return {key: float(values[row]) for row, key in enumerate(self.keys) if pulls[row] != 0.0}

    def bounds(self) -> tuple[FloatArray, FloatArray]:
        """(lowest, highest) pulls that a fit may reach, by a factor of `_FAR` at the most."""
        relative = self.relative
        reach = np.where(
            relative > 0.0, math.log(_FAR) / np.where(relative > 0, relative, 1.0), _FAR
        )
        low = np.where(self.nominal > 0.0, -np.minimum(reach, _FAR), 0.0)
        return low, np.minimum(reach, _FAR)

    def price(self, pulls: FloatArray) -> float:
        """What leaving the sheet costs: the sum of (2 pull)^2."""
        return float(PULL_PRICE * pulls @ pulls)

    def priced(self, cost: float, pulls: FloatArray) -> float:
        """A mean square, raised by the price of its pulls.

        With the level of what is left unknown, the logarithm of a mean square counts as many times
        as there are pieces of evidence; the price adds to it.
        """
        return raised(cost, self.price(pulls) / self.evidence)

    def free(self, effects: Collection[str]) -> BoolArray:
        """Constants that are fitted beside `effects`: none of these stands for them, bool[k]."""
        taken = {CATALOGUE[name].constant for name in effects}
        return np.array([key not in taken for key in self.keys], dtype=bool)

    def pulled_to(
        self, effect: str, values: Mapping[str, float], drive: DriveParameters
    ) -> FloatArray:
        """The pull, float64[k], that makes of the sheet what a constant's effect makes of it.

        Zeros where the effect stands for no uncertain constant. drive: the nominal one.
        """
        pulls = self.at_nominal
        row = self.index(CATALOGUE[effect].constant)
        if row is not None:
            off = values[CATALOGUE[effect].parameters[0].name] - CATALOGUE[effect].neutral(drive)
            relative = self.relative[row]
            pulls[row] = off / self.tolerance[row]
            if relative > 0.0:
                pulls[row] = math.log(max(1.0 + relative * pulls[row], 1.0 / _FAR)) / relative
        return pulls

    def index(self, key: str | None) -> int | None:
        """Where a constant stands among the uncertain ones; None where it is not one of them."""
        return self.keys.index(key) if key in self.keys else None


def stated(pulls: FloatArray, relative: FloatArray) -> FloatArray:
    """Pulls as a data sheet counts them, (s - s0) / t, where that is more; float64[..., k].

    Upwards it is. Downwards a half is as far off as a double, not half as far. relative:
    float64[k], tolerances as shares of the nominal values.
    """
    up = np.clip(relative * pulls, 0.0, math.log(_FAR))
    made: FloatArray = np.divide(np.expm1(up), relative, out=pulls.copy(), where=up > 0.0)
    return made


def raised(cost: float, price: float) -> float:
    """A cost whose logarithm is larger by a price, as far as that stays finite."""
    return cost * math.exp(min(price, _DEAREST))
