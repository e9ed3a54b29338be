"""What the panels of the pictures can show, by name: a label, and the signal of a run."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ecyl_ros.arrays import FloatArray
from ecyl_ros.drive.parameters import DriveParameters
from ecyl_ros.gap.replay.evidence import ReplayEvidence, Smoother
from ecyl_ros.recording.signals import Recording

SPECTRUM = "spectrum"  # in place of a coordinate


@dataclass(frozen=True)
class Run:
    """A recording and its residuals with the nominal model.

    simulated: the replay's signals by name. voltage_v: residual of the winding's equation.
    """

    recording: Recording
    evidence: ReplayEvidence
    simulated: dict[str, FloatArray]
    voltage_v: FloatArray

    @property
    def drive(self) -> DriveParameters:
        """The nominal model."""
        return self.evidence.drive


def _lag(run: Run) -> FloatArray:
    wanted = run.recording.reference_position_m / run.drive.transmission.rod_per_rotor
    return (wanted - run.recording.rotor_position_rad) * 1e3


TRACES = {
    "lag": ("rotor behind the reference / mrad", _lag),
    "current": ("current i_q / A", lambda run: run.recording.current_q_a),
    "voltage": ("voltage u_q / V", lambda run: run.recording.voltage_q_v),
    "parting": (
        "rod minus rotor / mrad",
        lambda run: (
            (
                run.recording.rod_position_m / run.drive.transmission.rod_per_rotor
                - run.recording.rotor_position_rad
            )
            * 1e3
        ),
    ),
    "current_gap": (
        "current residual / A",
        lambda run: run.recording.current_q_a - run.simulated["current_q"],
    ),
    "voltage_gap": (
        "voltage residual / V",
        lambda run: run.recording.voltage_q_v - run.simulated["voltage_q"],
    ),
    "speed_gap": (
        "speed residual / (rad/s)",
        lambda run: run.recording.rotor_velocity_rad_per_s - run.simulated["rotor_velocity"],
    ),
    "rod_gap": (
        "rod residual / µm",
        lambda run: (run.recording.rod_position_m - run.simulated["rod_position"]) * 1e6,
    ),
}


def _against_motion(run: Run) -> FloatArray:
    speed = run.evidence.rotor_speed_rad_s
    moving = np.abs(speed) > 0.02 * np.max(np.abs(speed))
    return np.where(moving, -run.evidence.torque_nm * np.sign(speed), np.nan)


LEFT = {
    "lag": ("rotor behind the reference / mrad", _lag),
    "speed": (
        "speed residual / (rad/s)",
        lambda run: run.evidence.rotor_speed_error_rad_s,
    ),
    "torque": ("unmodelled torque / N m", lambda run: run.evidence.torque_nm),
    "drag": ("unmodelled drag / N m", _against_motion),
    "voltage": ("unmodelled voltage / V", lambda run: run.voltage_v),
    "rod": ("rod residual / mrad", lambda run: run.evidence.rod_error_rad * 1e3),
    "current": ("current residual / A", lambda run: run.evidence.current_error_a),
    "recorded_current": ("current recorded / A", lambda run: run.recording.current_q_a),
    "recorded_voltage": ("voltage recorded / V", lambda run: run.recording.voltage_q_v),
}


def _turns(angle: FloatArray) -> FloatArray:
    return np.mod(angle / (2.0 * np.pi), 1.0)


def _acceleration(run: Run) -> FloatArray:
    return Smoother(run.evidence.time_s)(run.evidence.rotor_speed_rad_s, 1)


OVER = {
    "speed": ("rotor speed / (rad/s)", lambda run: run.evidence.rotor_speed_rad_s),
    "position": ("rod position / mm", lambda run: run.recording.rod_position_m * 1e3),
    "rotor": ("turn of the rotor", lambda run: _turns(run.evidence.rotor_angle_rad)),
    "screw": (
        "turn of the screw",
        lambda run: _turns(run.evidence.rotor_angle_rad / run.drive.transmission.gear_ratio),
    ),
    "current": ("current i_q / A", lambda run: run.evidence.current_a),
    "command": ("commanded voltage u_q / V", lambda run: run.evidence.voltage_v),
    "motor": (
        "motor torque / N m",
        lambda run: run.drive.motor.torque_constant * run.evidence.current_a,
    ),
    "acceleration": ("rotor acceleration / (rad/s^2)", _acceleration),
    "model_current": ("current of the model / A", lambda run: run.simulated["current_q"]),
    "model_voltage": ("voltage of the model / V", lambda run: run.simulated["voltage_q"]),
    "time": ("time / s", lambda run: run.evidence.time_s),
}
