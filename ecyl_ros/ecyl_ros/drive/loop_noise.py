"""What the sensors' noise becomes on its way through the cascade's proportional gains and filters.

Every reading is followed as a pulse: what white noise becomes is the root of the summed squares of
the answer to one.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.signal import lfilter

from ..arrays import FloatArray
from .filters import kept_share
from .parameters import DriveParameters

_TIME_CONSTANTS = 20.0  # of the slowest filter that an answer is followed for


def speed_feedback_noise(drive: DriveParameters) -> float:
    """Standard deviation of the noise in the speed that the loop acts on, rad/s."""
    encoder, speed, _ = _speed_answers(drive)
    return math.hypot(*(_norm(one) for one in (encoder, speed)))


def current_command_noise(drive: DriveParameters) -> float:
    """Standard deviation of the noise in the current asked for, A, its own reading aside."""
    control = drive.controller
    encoder, speed, pulse = _speed_answers(drive)
    kp = control.position.kp
    kd = control.position.kd * (kp if control.form == "series" else 1.0)
    of_position, of_speed = kp, kd
    if control.structure == "cascade":
        of_position, of_speed = control.speed.kp * kp, control.speed.kp * (1.0 + kd)
    on_encoder, on_rod = of_speed * encoder, 0.0 * pulse
    if control.feedback == "rod":
        noise = _reading(drive.sensors.rod_position_noise, drive.sensors.rod_position_resolution)
        on_rod = of_position * noise / drive.transmission.rod_per_rotor * pulse
    else:
        on_encoder = on_encoder + of_position * _encoder_noise(drive) * pulse
    kept = kept_share(control.current_command_filter, control.rate)
    parts = (on_encoder, on_rod, of_speed * speed)
    return math.hypot(*(_norm(_low_pass(one, kept)) for one in parts))


def _speed_answers(drive: DriveParameters) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Speed feedback in answer to one standard deviation of encoder, of speed; and the pulse."""
    control = drive.controller
    kept = kept_share(control.speed_filter, control.rate)
    slowest = max(control.speed_filter, control.current_command_filter) * control.rate
    pulse = np.zeros(4 + math.ceil(_TIME_CONSTANTS * slowest))
    pulse[0] = 1.0
    if control.speed_source == "differences":
        steps = control.rate * np.diff(pulse, prepend=0.0)
        return _low_pass(_encoder_noise(drive) * steps, kept), 0.0 * pulse, pulse
    return 0.0 * pulse, _low_pass(drive.sensors.rotor_velocity_noise * pulse, kept), pulse


def _encoder_noise(drive: DriveParameters) -> float:
    return _reading(drive.sensors.rotor_position_noise, drive.sensors.rotor_position_resolution)


def _reading(noise: float, resolution: float) -> float:
    return math.hypot(noise, resolution / math.sqrt(12.0))


def _low_pass(values: FloatArray, kept: float) -> FloatArray:
    return np.asarray(lfilter([1.0 - kept], [1.0, -kept], values), dtype=np.float64)


def _norm(values: FloatArray) -> float:
    return float(np.sqrt(values @ values))
