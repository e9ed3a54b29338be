"""The block of a gap that no effect explains, from balances at the ports."""

from __future__ import annotations

import dataclasses

import pytest
from other_make import replayed
from sheets import exact

from ecyl_ros.drive.engine import simulate
from ecyl_ros.drive.parameters import Gains, PositionGains
from ecyl_ros.drive.reference.spec import make_reference
from ecyl_ros.drive.telemetry import simulation_recording
from ecyl_ros.effects.effect import BLOCKS
from ecyl_ros.gap.locate.block import CONTROLLER_BROKEN, possible_blocks
from ecyl_ros.gap.locate.controller_port import controller_check, delay_restores
from ecyl_ros.gap.locate.locate import beside_the_loop, by_port
from ecyl_ros.gap.replay.replay import Replay

CASES = [
    ({"resistance_error": {"resistance_ohm": 1.1}}, {"motor_electrical"}),
    ({"inverter_dead_time": {"voltage_v": 1.0}}, {"motor_electrical"}),
    ({"current_sensor_offset": {"offset_a": 0.15}}, {"sensor"}),
    ({"constant_load": {"force_n": 150.0}}, {"load"}),
    ({"rotor_coulomb_friction": {"coulomb_nm": 0.2}}, {"motor_mechanical"}),
    ({"cogging_torque": {"amplitude_nm": 0.06, "periods_per_rev": 12.0}}, {"motor_mechanical"}),
    ({"x_local_jam": {"coulomb_nm": 0.5, "place_m": 0.0, "width_m": 0.001}}, {"load"}),
    ({"lead_error": {"lead_m": 0.0198}}, {"transmission"}),
    (
        {"transmission_error": {"amplitude_rad": 0.02, "periods_per_screw_rev": 1.0}},
        {"transmission"},
    ),
    ({"encoder_eccentricity": {"amplitude_rad": 0.004}}, {"sensor"}),
    ({"measurement_delay": {"delay_s": 1.5e-4}}, {"timing"}),
    ({"stiffness_error": {"stiffness_nm_per_rad": 2000.0}}, {"transmission"}),
]


@pytest.mark.parametrize(("effects", "block"), CASES, ids=[next(iter(e)) for e, _ in CASES])
def test_port_checks_leave_the_true_block(effects, block) -> None:
    """On another make of machine the balances at the ports rule out blocks, never the true one."""
    replay = replayed(effects)
    possible = set(possible_blocks(by_port(replay)))
    assert block <= possible
    assert len(possible) <= 3 < len(BLOCKS)


MOVES = "moves:positions=0.02;-0.01;0.012;0,speed=0.05,acceleration=1,jerk=50,dwell=0.2"
CONTROLLERS = {
    "velocity feedforward": {"velocity_feedforward": 1.0},
    "acceleration feedforward": {
        "velocity_feedforward": 1.0,
        "acceleration_feedforward": 3e-3,
        "setpoint_filter": 2e-3,
    },
    "setpoint filter": {"setpoint_filter": 5e-3},
    "speed filter": {"speed_filter": 8e-4},
    "current command filter": {"current_command_filter": 6e-4},
    "differences": {"speed_source": "differences", "speed_filter": 1e-3},
    "derivative": {"position": PositionGains(kp=40.0, kd=0.1)},
    "no speed loop": {
        "structure": "position_to_current",
        "position": PositionGains(kp=32.0, ki=100.0, kd=0.8),
        "speed": Gains(kp=0.0),
    },
}


@pytest.mark.parametrize("kind", CONTROLLERS)
def test_the_controllers_own_equation_holds_for_the_controller_that_it_is(kind) -> None:
    """A controller with filters, feedforward or no speed loop passes its port check where the
    nominal model has the same, and fails it where the nominal model is the plain cascade."""
    plain = exact("bench")
    control = dataclasses.replace(plain.controller, **CONTROLLERS[kind])
    drive = dataclasses.replace(plain, controller=control)
    reference = make_reference(MOVES, drive, 6.0)
    noisy = dataclasses.replace(drive, sensors=dataclasses.replace(drive.sensors, noise_seed=5))
    run = simulate(noisy, lambda index: reference.sample(index / drive.sample_rate), 6.0)
    recording = simulation_recording(run, drive)

    def off(nominal) -> float:
        found = {one.block: one for one in by_port(Replay(recording, nominal, "recording"))}
        return found["controller"].typical_ratio

    own, other = off(drive), off(plain)
    assert own < CONTROLLER_BROKEN
    assert other > max(CONTROLLER_BROKEN, 1.5 * own)


def test_a_feed_constant_within_its_tolerance_breaks_no_balance() -> None:
    """Off by half of it, where an exact sheet says that the controller is another."""
    plain = exact("bench")
    off = dataclasses.replace(plain.controller, feed_scale=1.0001)
    drive = dataclasses.replace(plain, controller=off)
    reference = make_reference(MOVES, drive, 6.0)
    run = simulate(drive, lambda index: reference.sample(index / drive.sample_rate), 6.0)
    recording = simulation_recording(run, drive)

    def ratio(tolerance: float | str, found: float = 1.0) -> float:
        sheet = {"all": "exact", "controller.feed_scale": tolerance}
        replay = Replay(recording, dataclasses.replace(plain, tolerances=sheet), "recording")
        check = controller_check(replay.at({"controller.feed_scale": found}))
        assert check is not None
        return check.ratio

    assert ratio("exact") > CONTROLLER_BROKEN > ratio(2e-4)
    # A fit that has found half of it starts from there.
    assert ratio(2e-4, found=1.00005) == pytest.approx(ratio(2e-4), rel=0.1)


def test_a_load_that_rattles_between_samples_is_no_fault_of_the_controller() -> None:
    """A force of 120 N at 28 Hz: ten ticks to a sample, and impacts in between."""
    effects = {"periodic_disturbance": {"amplitude_n": 120.0, "frequency_hz": 28.0}}
    replay = replayed(effects)
    check = controller_check(replay)
    assert check is not None and check.ratio < CONTROLLER_BROKEN


@pytest.mark.parametrize(
    ("effects", "late"),
    [
        ({"measurement_delay": {"delay_s": 4e-4}}, True),
        ({"x_command_filter": {"time_constant_s": 0.01}}, False),
        ({"x_position_gain": {"kp": 30.0}}, False),
    ],
)
def test_a_late_measurement_is_told_from_a_controller_set_up_otherwise(effects, late) -> None:
    """Both break the controller's equation; a delay restores it where it is late alone."""
    replay = replayed(effects)
    assert possible_blocks(by_port(replay)) == ("timing", "controller")
    assert delay_restores(replay, CONTROLLER_BROKEN) == late


def test_noise_in_the_loop_breaks_no_balance() -> None:
    """A healthy drive whose loops answer the noise of their sensors, ten commands to a sample: each
    balance is within what that noise makes of it."""
    drive = exact("bench")
    sensors = dataclasses.replace(
        drive.sensors,
        rotor_position_noise=1e-5,
        rotor_velocity_noise=2e-3,
        current_noise=5e-3,
        rod_position_noise=5e-7,
        noise_seed=5,
    )
    drive = dataclasses.replace(drive, sensors=sensors)
    reference = make_reference(MOVES, drive, 6.0)
    run = simulate(drive, lambda index: reference.sample(index / drive.sample_rate), 6.0)
    replay = Replay(simulation_recording(run, drive), drive, "recording")
    ports = beside_the_loop(by_port(replay), replay)
    assert max(one.typical_ratio for one in ports) < 2.5


def test_without_electrical_signals_nothing_is_ruled_out() -> None:
    """No port checks, no block ruled out."""
    assert set(possible_blocks(())) == set(BLOCKS)
