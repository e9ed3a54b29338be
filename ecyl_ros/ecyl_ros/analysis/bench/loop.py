"""A hysteresis loop: torque and angle of the input shaft, output locked, in the order of time."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ...arrays import FloatArray
from ...errors import InputError

MIN_READINGS = 60


@dataclass(frozen=True, eq=False)
class Loop:
    """Readings of one test.

    Attributes:
        torque_nm: float64[n], on the input shaft.
        angle_rad: float64[n], of the input shaft; its zero does not matter.
        force_n: float64[n] on the locked rod, or None.
        displacement_m: float64[n] of the locked rod, or None.
        source: what errors and reports call it.
    """

    torque_nm: FloatArray = field(repr=False)
    angle_rad: FloatArray = field(repr=False)
    force_n: FloatArray | None = field(repr=False, default=None)
    displacement_m: FloatArray | None = field(repr=False, default=None)
    source: str = "loop"

    def __post_init__(self) -> None:
        count = self.torque_nm.size
        if count < MIN_READINGS:
            raise InputError(
                f"{self.source}: {count} readings of torque and angle, expected {MIN_READINGS} "
                "or more"
            )
        for name in ("torque_nm", "angle_rad"):
            values = getattr(self, name)
            if not np.isfinite(values).all():
                raise InputError(f"{self.source}: {name} holds NaN or infinity, expected numbers")
            if np.ptp(values) == 0.0:
                raise InputError(f"{self.source}: {name} never changes, expected a loaded shaft")
