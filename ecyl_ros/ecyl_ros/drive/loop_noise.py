"""What the sensors' noise becomes on its way through the cascade."""

from __future__ import annotations

import math

from .filters import kept_share
from .parameters import DriveParameters


def speed_feedback_noise(drive: DriveParameters) -> float:
    """Standard deviation of the noise in the speed that the loop acts on, rad/s.

    Of the speed reading, or of the encoder's steps over a tick, quantisation included; after the
    speed filter.
    """
    sensors, control = drive.sensors, drive.controller
    kept = kept_share(control.speed_filter, control.rate)
    if control.speed_source == "differences":
        angle = math.hypot(
            sensors.rotor_position_noise, sensors.rotor_position_resolution / math.sqrt(12.0)
        )
        # A step and the next share one reading, with opposite sign.
        return angle * control.rate * (1.0 - kept) * math.sqrt(2.0 / (1.0 + kept))
    return sensors.rotor_velocity_noise * math.sqrt((1.0 - kept) / (1.0 + kept))


def current_command_noise(drive: DriveParameters) -> float:
    """Standard deviation of the noise in the current asked for, through proportional gains, A.

    Measured position and speed count as independent, which they are not where the speed comes from
    differences: the gain of speed is then by far the larger one.
    """
    sensors, control = drive.sensors, drive.controller
    if control.feedback == "rod":
        steps, noise = sensors.rod_position_resolution, sensors.rod_position_noise
        position = math.hypot(noise, steps / math.sqrt(12.0)) / drive.transmission.rod_per_rotor
    else:
        steps, noise = sensors.rotor_position_resolution, sensors.rotor_position_noise
        position = math.hypot(noise, steps / math.sqrt(12.0))
    kp = control.position.kp
    kd = control.position.kd * (kp if control.form == "series" else 1.0)
    speed = speed_feedback_noise(drive)
    if control.structure == "position_to_current":
        asked = math.hypot(kp * position, kd * speed)
    else:
        asked = control.speed.kp * math.hypot(kp * position, (1.0 + kd) * speed)
    kept = kept_share(control.current_command_filter, control.rate)
    return asked * math.sqrt((1.0 - kept) / (1.0 + kept))
