"""A stand-in for a real drive: run it, and record it as a data logger would."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.signal import lfilter

from ....arrays import FloatArray
from ....drive.loop_noise import speed_feedback_noise
from ....drive.parameters import DriveParameters
from ....recording.signals import Recording
from . import equations
from .nuisances import Nuisances
from .physics import Physics

ENCODER_RAD = 2.0 * math.pi / 2**20
SCALE_M = 1e-7

# Rate constant of a dead time around zero current times a step, at the most. Heun's error of what
# dies out within is a sixth of its square, and a drive is there for moments only.
_DEAD_TIME_STEP = 0.1

# The signals a stand-in's recording is judged by, with the column each comes from.
MEASURED = {
    "rotor_position_rad": equations.ROTOR_ANGLE,
    "rotor_velocity_rad_per_s": equations.ROTOR_SPEED,
    "current_q_a": equations.CURRENT,
    "rod_position_m": equations.ROD,
    "voltage_q_v": equations.VOLTAGE,
}


@dataclass(frozen=True)
class Run:
    """What a machine did: sample instants s, and the signals of `MEASURED`, float64[n] each.

    Signals are free of noise unless the machine's own loop sees some and the run asked for it.
    """

    time_s: FloatArray
    position_m: FloatArray
    velocity_m_per_s: FloatArray
    signals: dict[str, FloatArray]

    @property
    def finite(self) -> bool:
        """Whether the machine kept its values finite to the end."""
        return all(bool(np.isfinite(values).all()) for values in self.signals.values())


def _resolution(drive: DriveParameters) -> FloatArray:
    sensors = drive.sensors
    return np.array(
        [
            sensors.rotor_position_resolution or ENCODER_RAD,
            sensors.rod_position_resolution or SCALE_M,
        ]
    )


def noise_floor(drive: DriveParameters) -> dict[str, float]:
    """Standard deviation that sensors alone leave in each signal of `MEASURED`, SI.

    A commanded voltage carries no noise; the size counted for it is what one tick of sensor noise
    would make of it through the gains.
    """
    sensors, control = drive.sensors, drive.controller
    encoder, scale = _resolution(drive) / math.sqrt(12.0)
    gain = control.speed.kp
    if control.structure == "position_to_current":
        gain = control.position.kd * (control.position.kp if control.form == "series" else 1.0)
    speed = gain * speed_feedback_noise(drive)
    floor = {
        "rotor_position_rad": math.hypot(sensors.rotor_position_noise, encoder),
        "rotor_velocity_rad_per_s": sensors.rotor_velocity_noise,
        "current_q_a": sensors.current_noise,
        "rod_position_m": math.hypot(sensors.rod_position_noise, scale),
        "voltage_q_v": control.current.kp * math.hypot(speed, sensors.current_noise),
    }
    return {name: max(value, 1e-12) for name, value in floor.items()}


def _noise(drive: DriveParameters, rng: np.random.Generator, count: int) -> FloatArray:
    sensors = drive.sensors
    spread = [
        sensors.rotor_position_noise,
        sensors.rotor_velocity_noise,
        sensors.current_noise,
        sensors.rod_position_noise,
    ]
    return rng.normal(size=(count, 4)) * np.array(spread)


def _random_torque(
    physics: Physics, rng: np.random.Generator, ticks: int, tick_s: float
) -> FloatArray:
    """Coloured noise (first order), N m at each control tick; empty where there is none."""
    if physics.random_nm <= 0.0:
        return np.zeros(0)
    keep = math.exp(-physics.random_rate * tick_s)
    drive = rng.normal(size=ticks) * physics.random_nm * math.sqrt(1.0 - keep * keep)
    return np.ascontiguousarray(lfilter([1.0], [1.0, -keep], drive))


def _steps_per_tick(physics: Physics, nuisances: Nuisances, tick_s: float) -> int:
    """The integrator's, more of them where a dead time makes the winding stiff.

    Around zero current the lost voltage acts like a resistance, with a time constant that may be
    that of a step.
    """
    rate = physics.dead_time_v / (physics.dead_time_transition_a * physics.inductance)
    return max(nuisances.steps_per_tick, math.ceil(tick_s * abs(rate) / _DEAD_TIME_STEP))


def run_machine(
    physics: Physics,
    nuisances: Nuisances,
    drive: DriveParameters,
    reference: tuple[FloatArray, FloatArray],
    *,
    loop_noise: bool = False,
) -> Run:
    """Run the machine through a reference given at each control tick (m, m/s).

    loop_noise: let the loop see its share of the noise, and quantisation, if this machine is one
    whose loop does; the signals then carry what the loop saw.
    """
    position, velocity = reference
    ticks, every = len(position), drive.telemetry_every
    tick_s = 1.0 / drive.controller.rate
    rng = np.random.default_rng([nuisances.noise_seed, 1])
    torque = _random_torque(
        physics, np.random.default_rng([nuisances.noise_seed, 2]), ticks, tick_s
    )
    noisy = loop_noise and nuisances.loop_noise > 0.0
    samples = equations.run(
        physics.packed(),
        position,
        velocity,
        tick_s,
        _steps_per_tick(physics, nuisances, tick_s),
        every,
        nuisances.loop_noise * _noise(drive, rng, ticks) if noisy else np.zeros((0, 4)),
        _resolution(drive),
        torque,
    )
    return Run(
        time_s=np.arange(len(samples), dtype=np.float64) * (every * tick_s),
        position_m=position[::every],
        velocity_m_per_s=velocity[::every],
        signals={name: samples[:, column] for name, column in MEASURED.items()},
    )


def record_machine(
    physics: Physics,
    nuisances: Nuisances,
    drive: DriveParameters,
    reference: tuple[FloatArray, FloatArray],
) -> Recording:
    """The recording of a run, as the contract of recordings has it.

    i_d is 0, u_d and rod velocity are not measured, u_q is the command at the sample's tick, the
    rotor's torque is the nominal torque constant times the measured i_q.
    """
    run = run_machine(physics, nuisances, drive, reference, loop_noise=True)
    count = len(run.time_s)
    rng = np.random.default_rng([nuisances.noise_seed, 3])
    signals: dict[str, Any] = dict(run.signals)
    encoder, scale = _resolution(drive)
    noise = math.sqrt(1.0 - nuisances.loop_noise**2) * _noise(drive, rng, count)
    logged = {
        "rotor_position_rad": encoder,
        "rotor_velocity_rad_per_s": 0.0,
        "current_q_a": 0.0,
        "rod_position_m": scale,
    }
    for column, (name, step) in enumerate(logged.items()):
        values = signals[name] + noise[:, column]
        signals[name] = step * np.round(values / step) if step else values
    jitter = nuisances.stamp_jitter_s * rng.normal(size=count)
    stamps = nuisances.epoch_ns + np.round((run.time_s + jitter) * 1e9).astype(np.int64)
    return Recording(
        stamp_ns=stamps,
        reference_position_m=run.position_m,
        reference_velocity_m_per_s=run.velocity_m_per_s,
        rotor_torque_nm=drive.motor.torque_constant * signals["current_q_a"],
        current_d_a=np.zeros(count),
        **signals,
    )
