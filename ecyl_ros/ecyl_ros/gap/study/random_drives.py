"""Drives that no bench has seen: data sheet, controller, sensors and logger, drawn as they come.

Everything hangs on the size of the motor, as in a maker's catalogue: torque grows with the 3/4th
power of the rotor's inertia, winding and supply go with rated torque and speed, loops are tuned by
bandwidth to what the motor has to turn.
"""

from __future__ import annotations

import math

import numpy as np

from ...drive.parameters import (
    ControllerParameters,
    DriveParameters,
    Gains,
    LimitParameters,
    LoadParameters,
    MotorParameters,
    PositionGains,
    SensorParameters,
    TransmissionParameters,
)
from ...drive.stability import growth_rate
from ...errors import InputError
from .cylinder.stage import Setup

ROTOR_INERTIA = (1e-5, 1e-2)  # kg m^2
LOAD_OVER_ROTOR = (0.4, 8.0)  # inertia at the rotor's shaft
LEAD_M = (2e-3, 40e-3)
GEAR_RATIO = (1.0, 5.0)
RATED_SPEED = (200.0, 450.0)  # rad/s
ELECTRICAL_S = (0.5e-3, 5e-3)  # L/R
CURRENT_HZ = (300.0, 1500.0)  # bandwidths of the loops
POSITION_HZ = (3.0, 15.0)
SPEED_OVER_POSITION = (4.0, 8.0)
# Control rates whose ticks are whole numbers of the 10 us that stand-ins are stepped by.
RATES_HZ = (4000.0, 5000.0, 6250.0, 10000.0, 12500.0, 20000.0)
LOGGED_HZ = (250.0, 2000.0)
CONTACT_HZ = (150.0, 800.0)  # resonance of rotor against load with the flanks in touch
CONTACT_DAMPING = (0.02, 0.08)  # ratio of it
BACKLASH_RAD = (1.5e-3, 2e-2)
ROD_SPEED = 0.5  # m/s, at most
MISSING = {  # share of recordings that lack a signal
    "voltage_q_v": 0.12,
    "rod_position_m": 0.12,
    "rotor_velocity_rad_per_s": 0.12,
}

# Torque per current over back-EMF per speed: power-invariant, amplitude-invariant, RMS per phase.
# In each the winding's equation u = R i + L di/dt + Ke w holds with R and L of one phase.
CONVENTIONS = (1.0, 1.5, 3.0)

_TORQUE = 1690.0  # N m per (kg m^2)^(3/4): 0.3 N m at 1e-5 kg m^2, 5 at 4.5e-4, 53 at 1e-2
_OVERLOAD = 2.5  # peak over rated torque
_SHARPEST = 60.0  # 1/s, peak acceleration over peak speed of the references (a chirp up to 9 Hz)
_DRAWS = 200
_GROWTH = 1e-3  # 1/s; the integral that a position loop without one leaves unused stands at 0


def draw_setup(seed: int) -> Setup:
    """The drive of a seed, and how it is moved and recorded; its loop is stable."""
    rng = np.random.default_rng([seed, 5])
    for _ in range(_DRAWS):
        setup = _draw(rng)
        if setup is not None and growth_rate(setup.drive) < _GROWTH:
            return setup
    raise InputError(f"no stable drive in {_DRAWS} draws")


def _log(rng: np.random.Generator, bounds: tuple[float, float]) -> float:
    return float(np.exp(rng.uniform(*np.log(bounds))))


def _draw(rng: np.random.Generator) -> Setup | None:
    """One draw; None where loops of such bandwidths do not go together."""

    def within(low: float, high: float) -> float:
        return float(rng.uniform(low, high))

    rotor = _log(rng, ROTOR_INERTIA)
    load = rotor * _log(rng, LOAD_OVER_ROTOR)
    whole = rotor + load
    torque = _TORQUE * rotor**0.75 * within(0.8, 1.25)
    rated = _log(rng, RATED_SPEED)
    lead = _log(rng, LEAD_M)
    ratio = 1.0 if rng.random() < 0.4 else round(within(*GEAR_RATIO), 2)
    per_rotor = lead / (2.0 * math.pi * ratio)

    # What it is moved by: within overload at the sharpest reversal of the references.
    speed = min(
        rated * within(0.3, 0.7), within(0.5, 0.9) * _OVERLOAD * torque / (whole * _SHARPEST)
    )
    speed = min(speed, ROD_SPEED / per_rotor)
    peak_torque = whole * _SHARPEST * speed

    supply = (48.0 if torque < 1.0 else 325.0 if torque < 4.0 else 560.0) / math.sqrt(3.0)
    back_emf = within(0.55, 0.8) * supply / rated
    constant = float(rng.choice(CONVENTIONS)) * back_emf
    amperes = torque / constant
    resistance = within(0.03, 0.12) * supply / amperes
    inductance = resistance * _log(rng, ELECTRICAL_S)

    rate = float(rng.choice(RATES_HZ))
    delay = int(rng.random() < 0.3)
    current_hz = min(_log(rng, CURRENT_HZ), rate / (12.0 + 6.0 * delay))
    position_hz = _log(rng, POSITION_HZ)
    speed_hz = position_hz * within(*SPEED_OVER_POSITION)
    # In its clearance the rotor turns alone, and the speed loop is faster by the inertias' ratio.
    slower = min(1.0, 0.4 * current_hz / (speed_hz * whole / rotor))
    position_hz, speed_hz = position_hz * slower, speed_hz * slower
    contact_hz = _log(rng, CONTACT_HZ)
    if position_hz < POSITION_HZ[0] or contact_hz < 3.0 * speed_hz:
        return None
    contact = 2.0 * math.pi * contact_hz
    stiffness = contact**2 * rotor * load / whole
    damping = 2.0 * within(*CONTACT_DAMPING) * stiffness / contact
    segments: tuple[float, ...] = (stiffness,)
    breaks: tuple[float, ...] = ()
    if rng.random() < 0.2:  # soft until all rollers carry
        segments, breaks = (within(0.4, 0.8) * stiffness, stiffness), (0.3 * peak_torque,)
    current_kp = 2.0 * math.pi * current_hz * inductance
    speed_kp = 2.0 * math.pi * speed_hz * whole / constant

    every = [k for k in range(1, 101) if LOGGED_HZ[0] <= rate / k <= LOGGED_HZ[1]]
    drive = DriveParameters(
        motor=MotorParameters(
            resistance=resistance,
            inductance=inductance,
            torque_constant=constant,
            back_emf_constant=back_emf,
            rotor_inertia=rotor,
            viscous_friction=within(0.005, 0.04) * peak_torque / speed,
        ),
        transmission=TransmissionParameters(
            lead=lead,
            gear_ratio=ratio,
            backlash=_log(rng, BACKLASH_RAD),
            stiffness=segments,
            stiffness_breaks=breaks,
            contact_damping=damping,
        ),
        load=LoadParameters(
            inertia=load, viscous_friction=within(0.02, 0.12) * peak_torque / speed
        ),
        controller=ControllerParameters(
            rate=rate,
            position=PositionGains(kp=2.0 * math.pi * position_hz),
            speed=Gains(kp=speed_kp, ki=speed_kp * 2.0 * math.pi * speed_hz * within(0.08, 0.2)),
            current=Gains(kp=current_kp, ki=current_kp * resistance / inductance),
            delay_ticks=delay,
            current_limit=3.0 * amperes,
            voltage_limit=supply,
        ),
        sensors=SensorParameters(
            rotor_position_noise=_log(rng, (3e-6, 3e-5)),
            rotor_velocity_noise=speed * _log(rng, (5e-5, 5e-4)),
            current_noise=amperes * _log(rng, (5e-4, 5e-3)),
            rod_position_noise=_log(rng, (1.5e-7, 1.5e-6)),
            rotor_position_resolution=2.0 * math.pi / 2.0 ** int(rng.integers(18, 24)),
            rod_position_resolution=float(rng.choice([5e-8, 1e-7, 5e-7])),
        ),
        limits=LimitParameters(
            stroke_min=-2.0 * speed * per_rotor,
            stroke_max=2.0 * speed * per_rotor,
            speed=1.5 * speed * per_rotor,
        ),
        telemetry_rate=rate / int(rng.choice(every)),
    )
    lot, missing = rng.random(), frozenset[str]()
    for name, share in MISSING.items():
        if 0.0 <= lot < share:
            missing = frozenset({name})
        lot -= share
    # Quieter and quicker drives than the bench show smaller differences: look for their size soon.
    return Setup(drive, peak_speed=speed, missing=missing, drawn=True, full_draws=1, shrinks=0.5)
