"""The exact solution of the plant for a held voltage: matrix exponentials between contacts.

Independent of the compiled plant. Without electrical cross-coupling (no pole pairs) the plant is
linear in every mode of the transmission, so each stretch between two contacts is a matrix
exponential; the instants at which the mode changes are found by bisection to 1e-14 s.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import expm

from ecyl_ros.drive.parameters import DriveParameters


class ExactPlant:
    """States: rotor angle, rotor speed, load angle, load speed, i_q; rad, rad/s, A."""

    def __init__(self, drive: DriveParameters) -> None:
        self.drive = drive
        transmission = drive.transmission
        self.starts = [(0.0, 0.0)]  # deflection rad and torque N m where each segment begins
        for stiffness, torque in zip(
            transmission.stiffness, transmission.stiffness_breaks, strict=False
        ):
            deflection, before = self.starts[-1]
            self.starts.append((deflection + (torque - before) / stiffness, torque))

    def mode(self, x: np.ndarray) -> tuple[int, int]:
        """(side, segment); side 0 when nothing is transmitted."""
        transmission = self.drive.transmission
        twist, rate = x[0] - x[2], x[1] - x[3]
        side = 1 if twist > 0 else -1
        overlap = side * twist - transmission.backlash / 2
        if overlap <= 0:
            return 0, 0
        segment = max(i for i, (start, _) in enumerate(self.starts) if overlap > start or i == 0)
        deflection, torque = self.starts[segment]
        pushed = torque + transmission.stiffness[segment] * (overlap - deflection)
        if pushed + transmission.contact_damping * side * rate <= 0:
            return 0, 0
        return side, segment

    def system(self, mode: tuple[int, int], u_q: float) -> np.ndarray:
        """Augmented matrix [A b; 0 0] of x' = A x + b in this mode."""
        motor, load, transmission = self.drive.motor, self.drive.load, self.drive.transmission
        a = np.zeros((6, 6))
        a[0, 1] = a[2, 3] = 1.0
        a[1, 1] = -motor.viscous_friction / motor.rotor_inertia
        a[1, 4] = motor.torque_constant / motor.rotor_inertia
        a[3, 3] = -load.viscous_friction / load.inertia
        a[4, 1] = -motor.back_emf_constant / motor.inductance
        a[4, 4] = -motor.resistance / motor.inductance
        a[4, 5] = u_q / motor.inductance
        side, segment = mode
        if side:
            deflection, torque = self.starts[segment]
            stiffness = transmission.stiffness[segment]
            offset = side * (torque - stiffness * (deflection + transmission.backlash / 2))
            row = np.array(
                [
                    stiffness,
                    transmission.contact_damping,
                    -stiffness,
                    -transmission.contact_damping,
                    0.0,
                    offset,
                ]
            )
            a[1] -= row / motor.rotor_inertia
            a[3] += row / load.inertia
        return a

    def advance(self, x: np.ndarray, u_q: float, duration: float) -> tuple[np.ndarray, int]:
        """State after `duration` s with u_q held, V, and the number of mode changes on the way."""
        z = np.append(np.asarray(x, dtype=float), 1.0)
        left, changes = duration, 0
        while left > 0:
            mode = self.mode(z)
            a = self.system(mode, u_q)
            look = min(2e-6, left)  # short against the fastest oscillation
            step = expm(a * look)
            passed, now = 0.0, z
            while passed < left - 1e-15:
                ahead = step @ now
                if self.mode(ahead) != mode:
                    break
                now, passed = ahead, passed + look
                if passed + look > left:
                    look = left - passed
                    step = expm(a * look)
            else:
                return now[:5], changes
            early, late = 0.0, look
            while late - early > 1e-14:
                middle = (early + late) / 2
                if self.mode(expm(a * middle) @ now) == mode:
                    early = middle
                else:
                    late = middle
            z = expm(a * late) @ now
            left -= passed + late
            changes += 1
        return z[:5], changes
