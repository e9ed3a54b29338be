"""The three lines of equation (7), as torque over angle, and the equation as printed beside it.

The third branch of equation (7) is put right here: for a continuous curve its last term must be
(k2 - k3) T2, where (k2 - k3) T1 is printed, so

    theta = k1 T                                   up to T1
    theta = k2 T + (k1 - k2) T1                    up to T2
    theta = k3 T + (k1 - k2) T1 + (k2 - k3) T2     beyond

and the same with both signs turned round for negative torque.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...arrays import FloatArray


@dataclass(frozen=True)
class ThreeLines:
    """k1, k2, k3 in rad/(N m), T1, T2 in N m, with 0 <= T1 <= T2.

    A plain dead zone has T1 = 0 and an infinite k1: `half_clearance_rad` then says how wide it is.
    """

    k1: float
    k2: float
    k3: float
    t1: float
    t2: float
    half_clearance_rad: float = 0.0

    def angle_rad(self, torque_nm: FloatArray) -> FloatArray:
        """Equation (7) put right, float64[n]; at T = 0 of a plain dead zone its middle."""
        torque = np.asarray(torque_nm, dtype=np.float64)
        size = np.abs(torque)
        first = np.minimum(size, self.t1) * self.k1 if self.t1 > 0.0 else self.half_clearance_rad
        second = np.clip(size - self.t1, 0.0, self.t2 - self.t1) * self.k2
        third = np.maximum(size - self.t2, 0.0) * self.k3
        return np.asarray(np.sign(torque) * (first + second + third), dtype=np.float64)

    def angle_as_printed_rad(self, torque_nm: FloatArray) -> FloatArray:
        """Equation (7) as printed, with (k2 - k3) T1 in its third branch."""
        torque = np.asarray(torque_nm, dtype=np.float64)
        wrong = np.where(np.abs(torque) >= self.t2, (self.k2 - self.k3) * (self.t1 - self.t2), 0.0)
        return self.angle_rad(torque) + np.sign(torque) * wrong

    @property
    def jump_as_printed_rad(self) -> float:
        """By how much the printed curve falls back at T2."""
        return (self.k2 - self.k3) * (self.t2 - self.t1)
