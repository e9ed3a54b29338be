"""What makes one stand-in differ from the next without being a fault.

Nobody fits these. They are small, each by what it leaves in the signals: a nominal model must still
stand at about the noise floor. For what moves the load through its clearance that leaves hundredths
of a percent (a friction of 1e-4 of the peak torque on the load is three floors already), for
resistance, inductance and back-EMF two tenths of a percent.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from ....drive.packed import fastest_rate
from ....drive.parameters import DriveParameters
from .physics import Physics

_RATE_STEP = 0.02  # rate constant of a machine times a step of its integrator, at the most


@dataclass(frozen=True)
class Nuisances:
    """How one machine is made, beyond its `Physics`."""

    steps_per_tick: int  # of the integrator
    loop_noise: float  # share of the sensors' noise that the loop sees too, 0 to 1
    stamp_jitter_s: float
    epoch_ns: int
    noise_seed: int


def add_nuisances(
    physics: Physics,
    drive: DriveParameters,
    peak_torque: float,
    rng: np.random.Generator,
    size: float = 1.0,
) -> tuple[Physics, Nuisances]:
    """A machine like `physics`, made a little differently.

    peak_torque: N m, of its motion. size: factor on all differences, for drives more sensitive
    than the bench.
    """

    def off(share: float) -> float:
        return 1.0 + size * share * rng.uniform(-1.0, 1.0)

    made = replace(
        physics,
        resistance=physics.resistance * off(2e-3),
        inductance=physics.inductance * off(2e-3),
        back_emf_constant=physics.back_emf_constant * off(2e-3),
        torque_constant=physics.torque_constant * off(3e-4),
        rotor_inertia=physics.rotor_inertia * off(1e-3),
        load_inertia=physics.load_inertia * off(1.5e-4),
        rotor_viscous=physics.rotor_viscous * off(5e-3),
        load_viscous=physics.load_viscous * off(1.5e-4),
        contact_damping=physics.contact_damping * off(1.5e-2),
        stiffness=tuple(value * off(4e-3) for value in physics.stiffness),
        half_backlash=physics.half_backlash * off(2e-4),
        dead_time_transition_a=float(10.0 ** rng.uniform(-2.0, -0.9)),
        pwm_step_v=float(size * rng.choice([0.0, 1.0, 2.0]) * 1e-3),
        rotor_coulomb=size * 2e-5 * peak_torque * rng.uniform(0.0, 1.0),
        second_cogging_nm=size * 8e-5 * peak_torque * rng.uniform(0.0, 1.0),
        second_cogging_periods=float(rng.choice([6, 12, 24, 36])),
        second_cogging_phase=float(rng.uniform(0.0, 2.0 * np.pi)),
        rotor_bristle_rad=float(10.0 ** rng.uniform(-4.3, -3.3)),
        load_bristle_rad=float(10.0 ** rng.uniform(-4.3, -3.3)),
        bristle_ratio=float(rng.uniform(0.1, 0.6)),
        rotor_angle=float(rng.normal(0.0, drive.sensors.rotor_position_noise)),
        load_angle=size * float(rng.uniform(-0.01, 0.01)) * physics.half_backlash,
        load_speed=size * float(rng.uniform(-0.05, 0.05)) * physics.half_backlash,
    )
    return made, Nuisances(
        steps_per_tick=steps_of(drive) * int(rng.choice([1, 2])),
        # A drive averages within its tick: its own loop is quieter than what is logged. The whole
        # current noise in the loop would move the rotor by two floors of speed.
        loop_noise=size * float(rng.uniform(0.05, 0.12)) if rng.random() < 0.5 else 0.0,
        stamp_jitter_s=float(rng.choice([0.0, 1.0])) * 2e-7,
        epoch_ns=1_700_000_000_000_000_000 + int(rng.integers(10**15)),
        noise_seed=int(rng.integers(2**31)),
    )


def steps_of(drive: DriveParameters) -> int:
    """Integration steps per control tick: of 10 us, or as a stiff coupling needs.

    Heun's error goes by the square of rate and step; at 0.02 it stays below the voltage's floor.
    """
    tick_s = 1.0 / drive.controller.rate
    return max(1, round(tick_s / 1e-5), math.ceil(tick_s * fastest_rate(drive) / _RATE_STEP))
