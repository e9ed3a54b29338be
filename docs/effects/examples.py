"""What the pictures of the effect pages show: a size, a motion that excites it, and the panels.

An effect's meaning stands in its own file in `ecyl_ros/effects`; here is how it is photographed.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass, field

from ecyl_ros.drive.drive_file import load_drive, resolve_drive
from ecyl_ros.drive.engine import simulate
from ecyl_ros.drive.parameters import DriveParameters
from ecyl_ros.drive.reference.spec import make_reference
from ecyl_ros.drive.telemetry import simulation_recording
from ecyl_ros.effects.catalogue import CATALOGUE
from ecyl_ros.recording.signals import Recording

DRIVE = "bench"  # nominal drive of all pictures

# Written as `ecyl simulate --reference` takes them: m, m/s, m/s^2, m/s^3, Hz.
TURNS = "moves:positions=0.02;-0.01;0.012;0,speed=0.05,acceleration=1,jerk=50,dwell=0.2"
FAST = "moves:positions=0.02;-0.02,speed=0.2,acceleration=4,jerk=200,dwell=0.2"
SLOW = "moves:positions=0.012;0,speed=0.01,acceleration=1,jerk=50,dwell=0.2"
SWINGS = "sine:amplitude=0.004,frequency=1"
STOPS = "moves:positions=0.004;-0.004;0.008;-0.008,speed=0.05,acceleration=3,jerk=200,dwell=0.3"


@dataclass(frozen=True)
class Example:
    """One recording and its picture.

    values: of the effect; its other parameters have their defaults. reference, duration_s: the
    motion. zoom: from and to, s, of the close-ups. traces: two signals over time. against: (what
    is left of the model, coordinate that reveals it). highest_hz: of a spectrum. known: effects
    that the nominal drive has too.
    """

    values: Mapping[str, float]
    reference: str
    zoom: tuple[float, float]
    traces: tuple[str, ...]
    against: tuple[str, str]
    duration_s: float = 12.0
    highest_hz: float = 40.0
    known: Mapping[str, Mapping[str, float]] = field(default_factory=dict)


EXAMPLES: dict[str, Example] = {
    "back_emf_error": Example(
        {"back_emf_v_s_per_rad": 0.134},
        FAST,
        (0.0, 1.4),
        ("voltage", "speed_gap"),
        ("voltage", "speed"),
    ),
    "inverter_dead_time": Example(
        {"voltage_v": 0.8},
        SWINGS,
        (2.0, 3.5),
        ("voltage", "current_gap"),
        ("voltage", "current"),
    ),
    "inverter_gain": Example(
        {"gain": -0.1},
        FAST,
        (0.0, 1.4),
        ("voltage", "voltage_gap"),
        ("voltage", "command"),
    ),
    "resistance_error": Example(
        {"resistance_ohm": 1.1},
        FAST,
        (0.0, 1.4),
        ("voltage", "voltage_gap"),
        ("voltage", "current"),
    ),
    "torque_constant_error": Example(
        {"torque_constant_nm_per_a": 0.64},
        FAST,
        (0.0, 1.4),
        ("current", "current_gap"),
        ("torque", "motor"),
    ),
    "cogging_torque": Example(
        {"amplitude_nm": 0.05, "periods_per_rev": 24.0},
        SLOW,
        (0.1, 0.6),
        ("current", "speed_gap"),
        ("torque", "rotor"),
    ),
    "friction_drift": Example(
        {"coulomb_nm": 0.3, "rate_per_s": -0.15},
        TURNS,
        (0.0, 12.0),
        ("current", "current_gap"),
        ("drag", "time"),
    ),
    "rotor_coulomb_friction": Example(
        {"coulomb_nm": 0.2},
        SWINGS,
        (2.0, 3.5),
        ("current", "speed_gap"),
        ("torque", "speed"),
    ),
    "rotor_inertia_error": Example(
        {"inertia_kg_m2": 8e-4},
        STOPS,
        (0.0, 0.8),
        ("current", "current_gap"),
        ("torque", "acceleration"),
    ),
    "rotor_viscous_friction": Example(
        {"viscous_nm_s_per_rad": 8e-3},
        TURNS,
        (0.0, 1.5),
        ("current", "rod_gap"),
        ("torque", "speed"),
    ),
    "stribeck_friction": Example(
        {"coulomb_nm": 0.15, "static_nm": 0.3, "stribeck_rad_s": 3.0},
        SWINGS,
        (2.0, 3.5),
        ("current", "speed_gap"),
        ("torque", "speed"),
    ),
    "torque_ripple": Example(
        {"fraction": 0.1, "periods_per_rev": 12.0},
        SLOW,
        (0.1, 0.9),
        ("current", "speed_gap"),
        ("torque", "rotor"),
        known={"constant_load": {"force_n": 600.0}},
    ),
    "backlash_error": Example(
        {"backlash_rad": 9e-3},
        STOPS,
        (0.0, 0.8),
        ("parting", "speed_gap"),
        ("rod", "motor"),
    ),
    "lead_error": Example(
        {"lead_m": 0.02006},
        TURNS,
        (0.0, 3.0),
        ("parting", "rod_gap"),
        ("rod", "position"),
    ),
    "stiffness_error": Example(
        {"stiffness_nm_per_rad": 650.0},
        FAST,
        (0.0, 0.8),
        ("parting", "speed_gap"),
        ("rod", "motor"),
    ),
    "stiffness_hardening": Example(
        {"share": 0.1, "torque_nm": 1.0},
        FAST,
        (0.0, 0.8),
        ("parting", "speed_gap"),
        ("rod", "motor"),
    ),
    "transmission_error": Example(
        {"amplitude_rad": 0.01, "periods_per_screw_rev": 3.0},
        TURNS,
        (0.0, 3.0),
        ("parting", "rod_gap"),
        ("rod", "screw"),
    ),
    "constant_load": Example(
        {"force_n": 150.0},
        SWINGS,
        (2.0, 3.5),
        ("current", "parting"),
        ("torque", "speed"),
    ),
    "direction_dependent_friction": Example(
        {"coulomb_positive_nm": 0.1, "coulomb_negative_nm": 0.3},
        SWINGS,
        (2.0, 3.5),
        ("current", "current_gap"),
        ("torque", "speed"),
    ),
    "load_coulomb_friction": Example(
        {"coulomb_nm": 0.2},
        SWINGS,
        (2.0, 3.5),
        ("current", "speed_gap"),
        ("torque", "speed"),
    ),
    "load_dependent_friction": Example(
        {"coefficient": 0.15},
        FAST,
        (0.0, 1.4),
        ("current", "current_gap"),
        ("drag", "motor"),
    ),
    "load_inertia_error": Example(
        {"inertia_kg_m2": 2.5e-3},
        STOPS,
        (0.0, 0.8),
        ("current", "current_gap"),
        ("torque", "acceleration"),
    ),
    "load_viscous_friction": Example(
        {"viscous_nm_s_per_rad": 8e-3},
        TURNS,
        (0.0, 1.5),
        ("current", "rod_gap"),
        ("torque", "speed"),
    ),
    "local_jam": Example(
        {"coulomb_nm": 0.3, "position_m": 0.006, "width_m": 0.003},
        TURNS,
        (0.0, 3.0),
        ("current", "rod_gap"),
        ("drag", "position"),
    ),
    "periodic_disturbance": Example(
        {"amplitude_n": 60.0, "frequency_hz": 7.3},
        TURNS,
        (0.0, 1.5),
        ("current", "current_gap"),
        ("current", "spectrum"),
    ),
    "spring_load": Example(
        {"stiffness_n_per_m": 1.5e4},
        TURNS,
        (0.0, 3.0),
        ("current", "current_gap"),
        ("torque", "position"),
    ),
    "current_sensor_gain": Example(
        {"gain": 0.08},
        FAST,
        (0.0, 1.4),
        ("current", "voltage_gap"),
        ("current", "motor"),
    ),
    "current_sensor_offset": Example(
        {"offset_a": 0.15},
        STOPS,
        (0.0, 0.8),
        ("current", "current_gap"),
        ("torque", "speed"),
    ),
    "encoder_eccentricity": Example(
        {"amplitude_rad": 0.005},
        TURNS,
        (0.0, 3.0),
        ("parting", "rod_gap"),
        ("rod", "rotor"),
    ),
    "actuation_delay": Example(
        {"delay_s": 1.5e-4},
        STOPS,
        (0.0, 0.2),
        ("current", "voltage"),
        ("current", "spectrum"),
        highest_hz=500.0,
    ),
    "measurement_delay": Example(
        {"delay_s": 2e-4},
        STOPS,
        (0.0, 0.2),
        ("current", "speed_gap"),
        ("current", "spectrum"),
        highest_hz=500.0,
    ),
    "current_limit": Example(
        {"current_a": 6.0},
        FAST,
        (0.0, 0.7),
        ("current", "rod_gap"),
        ("recorded_current", "model_current"),
    ),
    "voltage_limit": Example(
        {"voltage_v": 18.0},
        FAST,
        (0.0, 0.7),
        ("voltage", "rod_gap"),
        ("recorded_voltage", "model_voltage"),
    ),
    "position_gain_error": Example(
        {"kp_per_s": 32.0},
        TURNS,
        (0.0, 1.5),
        ("lag", "rod_gap"),
        ("lag", "speed"),
    ),
    "position_integral_error": Example(
        {"ki_per_s2": 100.0},
        TURNS,
        (0.0, 3.0),
        ("lag", "rod_gap"),
        ("lag", "speed"),
    ),
    "speed_gain_error": Example(
        {"kp_a_s_per_rad": 0.6},
        STOPS,
        (0.0, 0.3),
        ("current", "speed_gap"),
        ("speed", "spectrum"),
        highest_hz=200.0,
    ),
    "speed_integral_error": Example(
        {"ki_a_per_rad": 60.0},
        STOPS,
        (0.0, 0.8),
        ("current", "speed_gap"),
        ("speed", "acceleration"),
    ),
    "current_gain_error": Example(
        {"kp_v_per_a": 4.0},
        STOPS,
        (0.0, 0.2),
        ("current", "voltage_gap"),
        ("current", "spectrum"),
        highest_hz=500.0,
    ),
    "current_integral_error": Example(
        {"ki_v_per_a_s": 6000.0},
        STOPS,
        (0.0, 0.2),
        ("current", "voltage_gap"),
        ("current", "spectrum"),
        highest_hz=500.0,
    ),
    "feed_constant_error": Example(
        {"error": 0.002},
        TURNS,
        (0.0, 1.5),
        ("lag", "rod_gap"),
        ("speed", "speed"),
    ),
    "velocity_feedforward_error": Example(
        {"share": 0.5},
        TURNS,
        (0.0, 1.5),
        ("lag", "rod_gap"),
        ("lag", "speed"),
    ),
    "acceleration_feedforward_error": Example(
        {"gain_a_s2_per_rad": 2e-3},
        STOPS,
        (0.0, 0.8),
        ("current", "current_gap"),
        ("current", "acceleration"),
    ),
    "command_filter": Example(
        {"time_constant_s": 4e-3},
        STOPS,
        (0.0, 0.8),
        ("lag", "rod_gap"),
        ("lag", "speed"),
    ),
    "current_command_filter": Example(
        {"time_constant_s": 4e-4},
        STOPS,
        (0.0, 0.2),
        ("current", "speed_gap"),
        ("current", "spectrum"),
        highest_hz=500.0,
    ),
    "feedback_filter": Example(
        {"time_constant_s": 5e-4},
        STOPS,
        (0.0, 0.2),
        ("current", "speed_gap"),
        ("current", "spectrum"),
        highest_hz=500.0,
    ),
}


def faulty_and_nominal(name: str) -> tuple[DriveParameters, DriveParameters]:
    """The drive with the effect, and its nominal model; their sensors' noise differs."""
    example = EXAMPLES[name]
    known = {key: CATALOGUE[key].complete(values) for key, values in example.known.items()}
    nominal = dataclasses.replace(load_drive(resolve_drive(DRIVE)), effects=known)
    sensors = dataclasses.replace(nominal.sensors, noise_seed=nominal.sensors.noise_seed + 1)
    effects = {**known, name: CATALOGUE[name].complete(example.values)}
    return dataclasses.replace(nominal, sensors=sensors, effects=effects), nominal


def record(drive: DriveParameters, example: Example) -> Recording:
    """A run of a drive on the example's motion."""
    reference = make_reference(example.reference, drive, example.duration_s)
    run = simulate(
        drive, lambda index: reference.sample(index / drive.sample_rate), example.duration_s
    )
    return simulation_recording(run, drive)
