"""The bench's sensors: readings that are off by up to their resolution."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...arrays import FloatArray
from .units import ARCSEC


@dataclass(frozen=True)
class BenchSensors:
    """What section 3.1 gives as resolution: +- each, in SI units; 0 for a perfect sensor.

    The paper does not say how an error within it is spread. Here every reading is off by an amount
    of its own, any amount within the resolution being equally likely.
    """

    torque_nm: float = 0.4
    angle_rad: float = 2.0 * ARCSEC
    force_n: float = 1.0
    displacement_m: float = 5e-6


PERFECT = BenchSensors(0.0, 0.0, 0.0, 0.0)


def read(truth: FloatArray, resolution: float, rng: np.random.Generator) -> FloatArray:
    """Readings of `truth` float64[n]: each off by a uniform draw from +-`resolution`."""
    return truth + rng.uniform(-resolution, resolution, truth.shape)
