"""The stand-in for a real drive: like the nominal model without effects, true to physics with."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from ecyl_ros.drive.drive_file import load_drive
from ecyl_ros.drive.engine import VOLTAGE, simulate
from ecyl_ros.drive.parameters import Gains, PositionGains, SensorParameters
from ecyl_ros.effects.catalogue import CATALOGUE as TWINS
from ecyl_ros.gap.study.cylinder.effects import EFFECTS
from ecyl_ros.gap.study.cylinder.excitation import draw_reference
from ecyl_ros.gap.study.cylinder.imposed import Draw
from ecyl_ros.gap.study.cylinder.inside import INSIDE
from ecyl_ros.gap.study.cylinder.machine import MEASURED, noise_floor, record_machine, run_machine
from ecyl_ros.gap.study.cylinder.nuisances import Nuisances
from ecyl_ros.gap.study.cylinder.outside import OUTSIDE
from ecyl_ros.gap.study.cylinder.physics import nominal_physics
from ecyl_ros.gap.study.cylinder.stage import Stage

DRIVE = load_drive("bench")
PLAIN = Nuisances(steps_per_tick=10, loop_noise=0.0, stamp_jitter_s=0.0, epoch_ns=0, noise_seed=1)
TICK_S = 1.0 / DRIVE.controller.rate
PER_ROTOR = DRIVE.transmission.rod_per_rotor

CATALOGUE = {  # the contract's effects: their blocks
    "rotor_coulomb_friction": "motor_mechanical",
    "rotor_viscous_friction": "motor_mechanical",
    "stribeck_friction": "motor_mechanical",
    "cogging_torque": "motor_mechanical",
    "torque_ripple": "motor_mechanical",
    "rotor_inertia_error": "motor_mechanical",
    "torque_constant_error": "motor_electrical",
    "back_emf_error": "motor_electrical",
    "resistance_error": "motor_electrical",
    "inverter_dead_time": "motor_electrical",
    "voltage_limit": "controller",
    "current_limit": "controller",
    "backlash_error": "transmission",
    "stiffness_error": "transmission",
    "transmission_error": "transmission",
    "lead_error": "transmission",
    "load_inertia_error": "load",
    "load_coulomb_friction": "load",
    "load_viscous_friction": "load",
    "constant_load": "load",
    "spring_load": "load",
    "periodic_disturbance": "load",
    "current_sensor_offset": "sensor",
    "encoder_eccentricity": "sensor",
    "measurement_delay": "timing",
    "actuation_delay": "timing",
}


def _rms(values):
    return float(np.sqrt(np.mean(np.square(values))))


def _machine(effects=(), **fields):
    machine = dataclasses.replace(nominal_physics(DRIVE), **fields)
    for name, values in dict(effects).items():
        EFFECTS[name].impose(machine, values, np.array([0.3, 1.1]))
    return machine


def _ramp(speed_rad_s, duration_s):
    """Rod reference that accelerates for 0.2 s to a constant rotor speed."""
    time = np.arange(round(duration_s / TICK_S)) * TICK_S
    rise = np.minimum(time / 0.2, 1.0)
    travelled = np.where(time < 0.2, 0.5 * time * rise, time - 0.1)
    return speed_rad_s * PER_ROTOR * travelled, speed_rad_s * PER_ROTOR * rise


def _end(machine, reference, name, last=200):
    run = run_machine(machine, PLAIN, DRIVE, reference)
    return float(np.mean(run.signals[name][-last:]))


def _hold(duration_s=2.0):
    return np.zeros(round(duration_s / TICK_S)), np.zeros(round(duration_s / TICK_S))


def test_without_effects_it_is_the_nominal_model() -> None:
    """Another integrator, no friction: within a tenth of the noise floor of the project's engine
    on every signal, over a whole excitation."""
    reference = draw_reference(np.random.default_rng(5), 12.0, TICK_S, 26.0 * PER_ROTOR)
    run = run_machine(nominal_physics(DRIVE), PLAIN, DRIVE, reference)
    quiet = dataclasses.replace(DRIVE, sensors=SensorParameters())
    position = np.append(reference[0][::10], reference[0][-1])
    velocity = np.append(reference[1][::10], 0.0)
    model = simulate(quiet, lambda index: (position[index], velocity[index]), 12.0)
    floor = noise_floor(DRIVE)
    for name, values in run.signals.items():
        expected = model.samples[:, VOLTAGE + 1] if name == "voltage_q_v" else model.signal(name)
        assert _rms(values - expected) < 0.1 * floor[name], name


def test_half_the_step_changes_nothing_that_counts() -> None:
    """Halving the integration step moves every signal by less than a third of its floor, with
    friction on both sides and dead time."""
    machine = _machine(
        {
            "rotor_coulomb_friction": {"coulomb_nm": 0.3},
            "load_coulomb_friction": {"coulomb_nm": 0.2},
            "inverter_dead_time": {"voltage_v": 1.0},
        },
    )
    reference = draw_reference(np.random.default_rng(6), 4.0, TICK_S, 26.0 * PER_ROTOR)
    fine = dataclasses.replace(PLAIN, steps_per_tick=20)
    coarse, finer = (run_machine(machine, n, DRIVE, reference) for n in (PLAIN, fine))
    floor = noise_floor(DRIVE)
    for name in MEASURED:
        assert _rms(coarse.signals[name] - finer.signals[name]) < 0.33 * floor[name], name


def test_a_hanging_load_is_held_by_its_torque_over_the_torque_constant() -> None:
    """At rest i_q = F lead / (2 pi N) / K_t with the true constants, and u_q = R i_q."""
    force, constant, resistance = 300.0, 0.6, 0.9
    machine = _machine(
        {
            "constant_load": {"force_n": force},
            "torque_constant_error": {"torque_constant_nm_per_a": constant},
            "resistance_error": {"resistance_ohm": resistance},
        }
    )
    current = force * PER_ROTOR / constant
    assert _end(machine, _hold(), "current_q_a") == pytest.approx(current, rel=1e-3)
    assert _end(machine, _hold(), "voltage_q_v") == pytest.approx(resistance * current, rel=1e-3)


def test_dead_time_costs_its_voltage() -> None:
    """Holding a load, the command is R i_q plus the voltage lost, with the current's sign."""
    for side in (1.0, -1.0):
        load = {"constant_load": {"force_n": 300.0 * side}}
        plain = _end(_machine(load), _hold(), "voltage_q_v")
        lossy = _machine(load | {"inverter_dead_time": {"voltage_v": 0.8}})
        assert _end(lossy, _hold(), "voltage_q_v") - plain == pytest.approx(0.8 * side, rel=1e-3)


@pytest.mark.parametrize(
    ("name", "values", "torque"),
    [
        ("rotor_coulomb_friction", {"coulomb_nm": 0.2}, 0.2),
        ("load_coulomb_friction", {"coulomb_nm": 0.2}, 0.2),
        (
            "stribeck_friction",
            {"coulomb_nm": 0.2, "static_nm": 0.5, "stribeck_rad_s": 1.0},
            0.2,
        ),
        ("rotor_viscous_friction", {"viscous_nm_s_per_rad": 0.02}, 0.02 * 10.0),
        ("load_viscous_friction", {"viscous_nm_s_per_rad": 0.02}, 0.02 * 10.0),
        ("x_quadratic_drag", {"drag_nm_s2_per_rad2": 0.003}, 0.003 * 100.0),
    ],
)
def test_friction_takes_its_torque_at_constant_speed(name, values, torque) -> None:
    """At a steady 10 rad/s the motor gives that torque more than without, either way round."""
    for side in (1.0, -1.0):
        ramp = _ramp(10.0 * side, 2.0)
        more = _end(_machine({name: values}), ramp, "current_q_a") - _end(
            _machine(), ramp, "current_q_a"
        )
        assert more * DRIVE.motor.torque_constant == pytest.approx(side * torque, rel=0.01)


def test_stiction_holds_what_sliding_would_not() -> None:
    """With the drive off and the load resting on its flank, a load torque between Coulomb and
    static level is held by the bristles; one above static level is not."""
    machine = _machine(
        {"stribeck_friction": {"coulomb_nm": 0.2, "static_nm": 0.5, "stribeck_rad_s": 1.0}},
        position_kp=0.0,
        speed_kp=0.0,
        speed_ki=0.0,
    )
    machine.load_angle = -machine.half_backlash
    moved = {}
    for torque in (0.35, 0.6):
        machine.force_n = torque / PER_ROTOR
        angle = run_machine(machine, PLAIN, DRIVE, _hold(1.0)).signals["rotor_position_rad"]
        moved[torque] = abs(angle[-1] - angle[500])
    assert moved[0.35] < 1e-5
    assert moved[0.6] > 0.5


def test_reversing_a_load_shows_clearance_and_twist() -> None:
    """Rotor less rod differs by the clearance and twice T / k between a load and its opposite."""
    backlash, stiffness, torque = 9e-3, 1500.0, 0.4
    twist = []
    for side in (1.0, -1.0):
        machine = _machine(
            {
                "backlash_error": {"backlash_rad": backlash},
                "stiffness_error": {"stiffness_nm_per_rad": stiffness},
                "constant_load": {"force_n": side * torque / PER_ROTOR},
            }
        )
        run = run_machine(machine, PLAIN, DRIVE, _hold(4.0))
        angle, rod = run.signals["rotor_position_rad"], run.signals["rod_position_m"]
        twist.append(np.mean(angle[-200:] - rod[-200:] / PER_ROTOR))
    assert twist[0] - twist[1] == pytest.approx(backlash + 2.0 * torque / stiffness, rel=1e-3)


def test_inertia_and_spring_show_in_the_current() -> None:
    """Under constant acceleration i_q K_t grows by the added inertia's share; at a place on a
    spring it is k x r more."""
    acceleration = 100.0
    time = np.arange(round(0.4 / TICK_S)) * TICK_S
    reference = (
        0.5 * acceleration * time**2 * PER_ROTOR,
        acceleration * time * PER_ROTOR,
    )
    constant = DRIVE.motor.torque_constant
    for name, nominal in (
        ("rotor_inertia_error", DRIVE.motor.rotor_inertia),
        ("load_inertia_error", DRIVE.load.inertia),
    ):
        heavy = _machine({name: {"inertia_kg_m2": nominal + 1e-3}})
        more = _end(heavy, reference, "current_q_a", 50) - _end(
            _machine(), reference, "current_q_a", 50
        )
        assert more * constant == pytest.approx(1e-3 * acceleration, rel=0.03)
    stop = np.full(round(3.0 / TICK_S), 4e-3)
    spring = _machine({"spring_load": {"stiffness_n_per_m": 5e4}})
    run = run_machine(spring, PLAIN, DRIVE, (stop, np.zeros_like(stop)))
    place = np.mean(run.signals["rod_position_m"][-200:])
    torque = np.mean(run.signals["current_q_a"][-200:]) * constant
    assert torque == pytest.approx(5e4 * place * PER_ROTOR, rel=1e-3)


def test_kinematic_error_and_lead_reach_the_rod_scale_alone() -> None:
    """Transmission error and lead leave rotor, current and voltage as they were, bit for bit."""
    reference = draw_reference(np.random.default_rng(7), 3.0, TICK_S, 26.0 * PER_ROTOR)
    plain = run_machine(_machine(), PLAIN, DRIVE, reference)
    wavy = run_machine(
        _machine({"transmission_error": {"amplitude_rad": 0.01, "periods_per_screw_rev": 2.0}}),
        PLAIN,
        DRIVE,
        reference,
    )
    longer = run_machine(_machine({"lead_error": {"lead_m": 0.0201}}), PLAIN, DRIVE, reference)
    for other in (wavy, longer):
        for name in ("rotor_position_rad", "current_q_a", "voltage_q_v"):
            np.testing.assert_array_equal(other.signals[name], plain.signals[name])
    rod = plain.signals["rod_position_m"]
    np.testing.assert_allclose(longer.signals["rod_position_m"], rod * 0.0201 / 0.02, rtol=1e-12)
    screw = rod / PER_ROTOR / DRIVE.transmission.gear_ratio
    np.testing.assert_allclose(
        wavy.signals["rod_position_m"] - rod,
        0.01 * PER_ROTOR * np.sin(2.0 * screw + 0.3),
        atol=1e-15,
    )


def test_loop_and_recording_see_the_same_wrong_sensor() -> None:
    """An offset is measured, not driven, at rest; an eccentric encoder follows the reference and
    the rod does not."""
    offset = _machine({"current_sensor_offset": {"offset_a": 0.2}})
    assert _end(offset, _hold(), "current_q_a") == pytest.approx(0.2, abs=1e-4)
    machine = _machine({"encoder_eccentricity": {"amplitude_rad": 0.05}})
    ramp = _ramp(5.0, 3.0)
    run = run_machine(machine, PLAIN, DRIVE, ramp)
    plain = run_machine(_machine(), PLAIN, DRIVE, ramp)
    late = slice(1500, None)
    seen = run.signals["rotor_position_rad"] - plain.signals["rotor_position_rad"]
    rod = (run.signals["rod_position_m"] - plain.signals["rod_position_m"]) / PER_ROTOR
    assert np.ptp(rod[late]) > 0.06
    assert np.ptp(seen[late]) < 0.6 * np.ptp(rod[late])


def test_an_actuation_delay_holds_the_voltage_back() -> None:
    """With a delay of 12 control ticks the current is what it was, 12 ticks later, at the start."""
    step = np.full(400, 1e-5), np.zeros(400)
    fast = dataclasses.replace(DRIVE, telemetry_rate=DRIVE.controller.rate)
    late = _machine({"actuation_delay": {"delay_s": 12e-4}})
    prompt = run_machine(_machine(), PLAIN, fast, step).signals["current_q_a"]
    delayed = run_machine(late, PLAIN, fast, step).signals["current_q_a"]
    assert np.all(delayed[:13] == 0.0)
    assert delayed[13] == pytest.approx(prompt[1], rel=1e-9)


def test_a_measurement_delay_is_in_the_loop_not_in_the_recording() -> None:
    """On a steep ramp the loop's late view costs speed times delay of position; stamps do not
    move."""
    ramp = _ramp(10.0, 1.5)
    late = _machine({"measurement_delay": {"delay_s": 4e-4}})
    ahead = _end(late, ramp, "rotor_position_rad") - _end(_machine(), ramp, "rotor_position_rad")
    assert ahead == pytest.approx(10.0 * 4e-4, rel=0.01)


@pytest.mark.parametrize(
    ("name", "values", "signal", "limit"),
    [
        ("voltage_limit", {"voltage_v": 2.0}, "voltage_q_v", 2.0),
        ("current_limit", {"current_a": 0.8}, "current_q_a", 0.8),
    ],
)
def test_limits_hold(name, values, signal, limit) -> None:
    """A signal that goes beyond the limit without it stays within (10 % for the current loop)."""
    reference = draw_reference(np.random.default_rng(8), 4.0, TICK_S, 26.0 * PER_ROTOR)
    free = run_machine(_machine(), PLAIN, DRIVE, reference).signals[signal]
    held = run_machine(_machine({name: values}), PLAIN, DRIVE, reference).signals[signal]
    assert np.max(np.abs(free)) > 1.2 * limit
    assert np.max(np.abs(held)) <= 1.1 * limit


def test_periodic_effects_show_at_their_period() -> None:
    """Cogging draws a torque line at its periods per revolution, a disturbance one at its Hz."""
    speed = 2.0 * math.pi  # one revolution a second
    ramp = _ramp(speed, 4.2)
    for effects, frequency in (
        ({"cogging_torque": {"amplitude_nm": 0.1, "periods_per_rev": 12.0}}, 12.0),
        ({"periodic_disturbance": {"amplitude_n": 50.0, "frequency_hz": 7.0}}, 7.0),
    ):
        run = run_machine(_machine(effects), PLAIN, DRIVE, ramp)
        current = run.signals["current_q_a"][-4000:]
        spectrum = np.abs(np.fft.rfft(current - np.mean(current)))
        assert np.argmax(spectrum) == pytest.approx(frequency * 4.0, abs=1)


def test_the_catalogue_is_the_contracts() -> None:
    """26 effects under the contract's names in its blocks, and at least ten outside it."""
    assert {name: effect.block for name, effect in INSIDE.items()} == CATALOGUE
    assert len(OUTSIDE) >= 10
    assert all(name.startswith("x_") for name in OUTSIDE)


CONTROLLER = [name for name, one in OUTSIDE.items() if one.block == "controller"]


def _against_engine(machine, drive, effects=None):
    """Largest rms difference to the project's engine over the signals, in noise floors."""
    reference = draw_reference(np.random.default_rng(5), 4.0, TICK_S, 26.0 * PER_ROTOR)
    run = run_machine(machine, PLAIN, drive, reference)
    quiet = dataclasses.replace(drive, sensors=SensorParameters(), effects=effects or {})
    position = np.append(reference[0][::10], reference[0][-1])
    velocity = np.append(reference[1][::10], 0.0)
    model = simulate(quiet, lambda index: (position[index], velocity[index]), 4.0)
    floor = noise_floor(DRIVE)
    return max(
        _rms(values - (model.samples[:, VOLTAGE + 1] if "volt" in name else model.signal(name)))
        / floor[name]
        for name, values in run.signals.items()
    )


@pytest.mark.parametrize("name", CONTROLLER)
def test_a_wrong_controller_is_the_engines_own_of_that_name(name) -> None:
    """Drawn at random, each comes within half a noise floor of the engine with the twin at the
    same value, and the nominal engine stays floors away."""
    draw = Draw(np.random.default_rng(3), DRIVE, Stage.of(3, DRIVE).scale)
    values = OUTSIDE[name].draw(draw)
    (value,) = values.values()
    twin = OUTSIDE[name].twin
    (parameter,) = TWINS[twin].parameters
    machine = _machine({name: values})
    assert _against_engine(machine, DRIVE, {twin: {parameter.name: value}}) < 0.5
    assert _against_engine(machine, DRIVE) > 1.5


def test_a_nominal_controller_with_every_extra_is_the_engines() -> None:
    """No speed loop, derivative, differences, filters, acceleration feedforward: all of them from
    the drive file, within a third of the noise floor of the engine. Without clearance: impacts
    would magnify what the two integrators differ by."""
    control = dataclasses.replace(
        DRIVE.controller,
        structure="position_to_current",
        position=PositionGains(kp=32.0, ki=100.0, kd=0.8),
        speed=Gains(kp=0.0),
        speed_source="differences",
        setpoint_filter=4e-3,
        speed_filter=3e-4,
        current_command_filter=2e-4,
        acceleration_feedforward=2e-3,
    )
    transmission = dataclasses.replace(DRIVE.transmission, backlash=0.0)
    drive = dataclasses.replace(DRIVE, controller=control, transmission=transmission)
    assert _against_engine(nominal_physics(drive), drive) < 0.33
    plain = dataclasses.replace(drive, controller=DRIVE.controller)
    assert _against_engine(nominal_physics(plain), drive) > 10.0


@pytest.mark.slow
def test_every_effect_shows_and_none_blows_up() -> None:
    """Each of the effects, drawn once, changes some signal by more than a noise floor and keeps
    all finite."""
    stage, floor = Stage.of(6, DRIVE), noise_floor(DRIVE)
    begun = tuple(one[: round(1.5 / TICK_S)] for one in stage.reference)
    rng = np.random.default_rng(9)
    for name, effect in EFFECTS.items():
        values = effect.draw(Draw(rng, DRIVE, stage.scale))
        machine = stage.with_effects({name: values}, 6)
        for reference in (begun, stage.reference):  # what warms up shows later
            run = run_machine(machine, stage.nuisances, DRIVE, reference)
            assert run.finite, name
            gaps = [
                _rms(signal - stage.healthy.signals[key][: len(signal)]) / floor[key]
                for key, signal in ((key, run.signals[key]) for key in floor)
            ]
            if max(gaps) > 1.0:
                break
        assert max(gaps) > 1.0, name


def test_a_recording_is_as_the_contract_has_it() -> None:
    """i_d 0, u_d and rod velocity NaN, torque the nominal constant times i_q, 20-bit encoder and
    0.1 um scale, 1 kHz, noise of the drive file's size."""
    reference = _hold(2.0)
    recording = record_machine(_machine(), PLAIN, DRIVE, reference)
    assert len(recording) == 2000
    assert recording.rate_hz == pytest.approx(1000.0)
    assert np.all(recording.current_d_a == 0.0)
    assert not recording.has("voltage_d_v")
    assert not recording.has("rod_velocity_m_per_s")
    np.testing.assert_allclose(
        recording.rotor_torque_nm, DRIVE.motor.torque_constant * recording.current_q_a
    )
    counts = recording.rotor_position_rad / (2.0 * math.pi / 2**20)
    np.testing.assert_allclose(counts, np.round(counts), atol=1e-4)
    steps = recording.rod_position_m / 1e-7
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-6)
    sensors = DRIVE.sensors
    assert np.std(recording.rotor_velocity_rad_per_s) == pytest.approx(
        sensors.rotor_velocity_noise, rel=0.1
    )
    assert np.std(recording.current_q_a) == pytest.approx(sensors.current_noise, rel=0.1)
    # Nothing moves, so a loop that sees no noise commands nothing.
    assert np.all(recording.voltage_q_v == 0.0)


@pytest.mark.parametrize("seed", [11, 12, 13])
def test_nuisances_stay_at_the_noise_floor(seed: int) -> None:
    """A drawn machine without effects stands within 1.1 floors of the nominal engine run."""
    stage = Stage.of(seed, DRIVE)
    recording = record_machine(stage.machine, stage.nuisances, DRIVE, stage.reference)
    quiet = dataclasses.replace(DRIVE, sensors=SensorParameters())
    position = np.append(stage.reference[0][::10], stage.reference[0][-1])
    velocity = np.append(stage.reference[1][::10], 0.0)
    model = simulate(quiet, lambda index: (position[index], velocity[index]), 12.0)
    for name, floor in noise_floor(DRIVE).items():
        expected = model.samples[:, VOLTAGE + 1] if name == "voltage_q_v" else model.signal(name)
        assert _rms(recording.signal(name) - expected) < 1.12 * floor, name


def test_a_machine_put_on_a_motion_again_differs_by_noise_alone():
    """So that a motion planned from one recording is played on the machine that gave it."""
    stage = Stage.of(3, DRIVE, 0.02)
    again = stage.on(stage.reference, 1, DRIVE)
    for name, values in stage.healthy.signals.items():
        assert np.array_equal(again.healthy.signals[name], values)
    assert again.with_effects({}, 3) == stage.with_effects({}, 3)
    assert again.nuisances.noise_seed != stage.nuisances.noise_seed
