"""Effects in the emulated drive, against what their equations say in closed form."""

from __future__ import annotations

import dataclasses
import math
from types import SimpleNamespace

import numpy as np
import pytest

from ecyl_ros.drive.drive_file import drive_from_flat, drive_to_flat, load_drive
from ecyl_ros.drive.engine import VOLTAGE, Simulation, simulate
from ecyl_ros.effects.catalogue import CATALOGUE
from ecyl_ros.errors import InputError
from ecyl_ros.gap.replay.sensor_noise import silent

# Section 3 of the contract: name, block, parameters.
CONTRACT = """
rotor_coulomb_friction motor_mechanical coulomb_nm
rotor_viscous_friction motor_mechanical viscous_nm_s_per_rad
stribeck_friction motor_mechanical coulomb_nm static_nm stribeck_rad_s
cogging_torque motor_mechanical amplitude_nm periods_per_rev
torque_ripple motor_mechanical fraction periods_per_rev
rotor_inertia_error motor_mechanical inertia_kg_m2
torque_constant_error motor_electrical torque_constant_nm_per_a
back_emf_error motor_electrical back_emf_v_s_per_rad
resistance_error motor_electrical resistance_ohm
inverter_dead_time motor_electrical voltage_v
voltage_limit controller voltage_v
current_limit controller current_a
backlash_error transmission backlash_rad
stiffness_error transmission stiffness_nm_per_rad
transmission_error transmission amplitude_rad periods_per_screw_rev
lead_error transmission lead_m
load_inertia_error load inertia_kg_m2
load_coulomb_friction load coulomb_nm
load_viscous_friction load viscous_nm_s_per_rad
constant_load load force_n
spring_load load stiffness_n_per_m
periodic_disturbance load amplitude_n frequency_hz
current_sensor_offset sensor offset_a
encoder_eccentricity sensor amplitude_rad
measurement_delay timing delay_s
actuation_delay timing delay_s
""".strip().splitlines()


@pytest.fixture(scope="module")
def drive():
    """The bench drive without noise, so that closed forms hold to the last digits."""
    return silent(load_drive("bench"))


def _run(drive, effects, reference, duration_s) -> Simulation:
    with_effects = dataclasses.replace(drive, effects=effects)
    return simulate(with_effects, reference, duration_s)


def _ramp(drive, speed_m_s):
    """A reference that goes at constant speed after a smooth start of 0.2 s."""
    period = 1.0 / drive.sample_rate

    def reference(index):
        t = index * period
        if t < 0.2:
            x = t / 0.2
            return speed_m_s * 0.2 * (x**3 - 0.5 * x**4), speed_m_s * (3 * x**2 - 2 * x**3)
        return speed_m_s * (t - 0.1), speed_m_s

    return reference


@pytest.mark.parametrize("line", CONTRACT)
def test_the_contracts_effects_are_there_by_name(line) -> None:
    """Name, block and reported parameters of every effect are those of the contract."""
    name, block, *parameters = line.split()
    effect = CATALOGUE[name]
    assert effect.block == block
    assert [one.name for one in effect.reported] == parameters


@pytest.mark.parametrize("name", sorted(CATALOGUE))
def test_every_effect_says_what_it_is(name) -> None:
    """Each effect has a title, a summary, an excitation, and units on its parameters."""
    effect = CATALOGUE[name]
    assert effect.title and effect.summary.endswith(".") and effect.excitation
    for quantity in effect.parameters:
        assert quantity.unit and quantity.meaning and quantity.low < quantity.high


def test_a_constant_load_takes_its_torque_in_current_at_rest(drive) -> None:
    """Held at rest against F the motor gives F x lead / (2 pi G) = K_t i."""
    run = _run(drive, {"constant_load": {"force_n": 300.0}}, lambda i: (0.0, 0.0), 2.0)
    expected = 300.0 * drive.transmission.rod_per_rotor / drive.motor.torque_constant
    assert run.signal("current_q_a")[-1] == pytest.approx(expected, rel=1e-6)


def test_a_spring_takes_its_torque_in_current_at_its_place(drive) -> None:
    """Held at x against a spring k the motor gives k x x lead / (2 pi G) = K_t i."""
    run = _run(drive, {"spring_load": {"stiffness_n_per_m": 1e5}}, _ramp(drive, 0.002), 1.5)
    # Creeping at constant speed: subtract what viscous friction takes.
    viscous = drive.motor.viscous_friction + drive.load.viscous_friction
    speed = run.signal("rotor_velocity_rad_per_s")[-1]
    rod = run.signal("rod_position_m")[-1]
    torque = 1e5 * rod * drive.transmission.rod_per_rotor + viscous * speed
    assert run.signal("current_q_a")[-1] * drive.motor.torque_constant == pytest.approx(
        torque, rel=2e-3
    )


@pytest.mark.parametrize(
    ("effects", "extra_nm"),
    [
        ({"rotor_coulomb_friction": {"coulomb_nm": 0.2}}, lambda w: 0.2),
        ({"load_coulomb_friction": {"coulomb_nm": 0.2}}, lambda w: 0.2),
        (
            {"stribeck_friction": {"coulomb_nm": 0.1, "static_nm": 0.3, "stribeck_rad_s": 4.0}},
            lambda w: 0.1 + 0.2 * math.exp(-((w / 4.0) ** 2)),
        ),
        ({"rotor_viscous_friction": {"viscous_nm_s_per_rad": 0.03}}, lambda w: 0.03 * w),
        ({"load_viscous_friction": {"viscous_nm_s_per_rad": 0.03}}, lambda w: 0.03 * w),
        (
            {
                "direction_dependent_friction": {
                    "coulomb_positive_nm": 0.3,
                    "coulomb_negative_nm": 0.1,
                    "viscous_positive_nm_s_per_rad": 0.01,
                }
            },
            lambda w: 0.3 + 0.01 * w,
        ),
    ],
)
def test_friction_takes_its_torque_at_constant_speed(drive, effects, extra_nm) -> None:
    """At constant speed the motor's torque is viscous friction plus the effect's level."""
    run = _run(drive, effects, _ramp(drive, 0.008), 1.5)
    speed = run.signal("rotor_velocity_rad_per_s")[-1]
    viscous = drive.motor.viscous_friction + drive.load.viscous_friction
    torque = run.signal("current_q_a")[-1] * drive.motor.torque_constant
    assert torque == pytest.approx(viscous * speed + extra_nm(speed), rel=1e-3)


def test_a_rotor_with_coulomb_friction_stays_where_less_torque_pulls(drive) -> None:
    """Below the friction level a torque moves the rotor by no more than the bristle gives."""
    effects = {"rotor_coulomb_friction": {"coulomb_nm": 0.5}}
    weak = dataclasses.replace(
        drive,
        controller=dataclasses.replace(
            drive.controller,
            position=dataclasses.replace(drive.controller.position, kp=0.0),
            speed=dataclasses.replace(drive.controller.speed, kp=0.0, ki=0.0),
        ),
        effects={**effects, "current_sensor_offset": {"offset_a": -0.4}},
    )
    run = simulate(weak, lambda i: (0.0, 0.0), 1.0)
    torque = 0.4 * drive.motor.torque_constant
    assert torque < 0.5
    # Slowly loaded to z = torque / level it would give -d ln(1 - z); the step swings further.
    slowly = -1e-4 * math.log(1.0 - torque / 0.5)
    assert slowly < run.signal("rotor_position_rad")[-1] < 2.0 * slowly
    assert abs(run.signal("rotor_velocity_rad_per_s")[-1]) < 1e-6


def test_a_wrong_lead_moves_the_rod_in_its_ratio(drive) -> None:
    """With the loop on the rotor the rod's travel scales with the true lead."""
    travels = []
    for effects in ({}, {"lead_error": {"lead_m": 0.021}}):
        rod = _run(drive, effects, _ramp(drive, 0.005), 1.5).signal("rod_position_m")
        travels.append(rod[-1] - rod[700])
    assert travels[1] / travels[0] == pytest.approx(21.0 / 20.0, rel=1e-6)


@pytest.mark.parametrize(
    ("straightness", "lost"),
    [(0.0, math.tanh), (1.0, lambda share: min(math.tanh(1.0) * share, 1.0))],
)
@pytest.mark.parametrize("transition_a", [0.03, 0.3])
def test_dead_time_is_made_up_for_by_the_commanded_voltage(
    drive, straightness, lost, transition_a
) -> None:
    """At constant current the command is higher by the lost voltage, 76 % at the transition."""
    plain = _run(drive, {}, _ramp(drive, 0.02), 1.0)
    values = {"voltage_v": 1.5, "transition_a": transition_a, "straightness": straightness}
    lossy = _run(drive, {"inverter_dead_time": values}, _ramp(drive, 0.02), 1.0)
    current = plain.signal("current_q_a")[-1]
    expected = 1.5 * lost(current / transition_a)
    rise = lossy.samples[-1, VOLTAGE + 1] - plain.samples[-1, VOLTAGE + 1]
    assert rise == pytest.approx(expected, rel=1e-3)


def test_a_weak_inverter_is_made_up_for_in_proportion(drive) -> None:
    """At constant speed the loop commands u / (1 + gain) where a true inverter would need u."""
    values = {"inverter_gain": {"gain": -0.05}}
    true, weak = (_run(drive, one, _ramp(drive, 0.02), 1.0) for one in ({}, values))
    wanted = true.samples[-1, VOLTAGE + 1] / 0.95
    assert weak.samples[-1, VOLTAGE + 1] == pytest.approx(wanted, rel=1e-6)


def test_an_offset_current_reading_leaves_no_torque_at_rest(drive) -> None:
    """At rest without load the reading is the offset and the rotor stands still."""
    run = _run(drive, {"current_sensor_offset": {"offset_a": 0.3}}, lambda i: (0.0, 0.0), 3.0)
    assert run.signal("current_q_a")[-1] == pytest.approx(0.3, abs=1e-4)
    assert abs(run.signal("rotor_velocity_rad_per_s")[-1]) < 1e-3


def test_an_eccentric_encoder_turns_the_rotor_by_its_error(drive) -> None:
    """The loop holds the reading on the reference: the rod errs by -A sin(theta + phase)."""
    effects = {"encoder_eccentricity": {"amplitude_rad": 0.02, "phase_rad": 1.0}}
    slow = _ramp(drive, 0.001)
    plain = _run(drive, {}, slow, 2.0)
    run = _run(drive, effects, slow, 2.0)
    shift = (run.samples[-1, 11] - plain.samples[-1, 11]) - (
        run.samples[0, 11] - plain.samples[0, 11]
    )
    angle = run.samples[-1, 11]
    assert shift == pytest.approx(-0.02 * math.sin(angle + 1.0), abs=2e-4)


def test_a_transmission_error_shows_on_the_rod_alone(drive) -> None:
    """The rod's reading carries A sin(n screw angle + phase); rotor and current do not change."""
    effects = {
        "transmission_error": {
            "amplitude_rad": 0.02,
            "periods_per_screw_rev": 3.0,
            "phase_rad": 0.5,
        }
    }
    plain, run = (_run(drive, e, _ramp(drive, 0.01), 1.0) for e in ({}, effects))
    assert np.array_equal(run.signal("rotor_position_rad"), plain.signal("rotor_position_rad"))
    screw = run.samples[:, 11] / drive.transmission.gear_ratio
    ripple = 0.02 * np.sin(3.0 * screw + 0.5) * drive.transmission.rod_per_rotor
    assert run.signal("rod_position_m") - plain.signal("rod_position_m") == pytest.approx(
        ripple, abs=1e-12
    )


@pytest.mark.parametrize("ticks", [1.0, 0.5])
def test_an_actuation_delay_of_whole_ticks_is_the_controllers_own(drive, ticks) -> None:
    """A delay of whole ticks equals `delay_ticks` to the last bit; a broken one lies between."""
    period = 1.0 / drive.controller.rate
    reference = _ramp(drive, 0.01)

    def with_ticks(count):
        controller = dataclasses.replace(drive.controller, delay_ticks=count)
        return simulate(dataclasses.replace(drive, controller=controller), reference, 0.5)

    run = _run(drive, {"actuation_delay": {"delay_s": ticks * period}}, reference, 0.5)
    if ticks == int(ticks):
        assert np.array_equal(run.samples, with_ticks(int(ticks)).samples)
        return
    below, above = (with_ticks(int(ticks) + step).samples for step in (0, 1))
    # Late by half a tick: as long as the loop is calm, the mean of its neighbours.
    early = slice(0, 60)
    apart = np.abs(above[early, 9] - below[early, 9]).max()
    mean = 0.5 * (above + below)[early, 9]
    assert np.abs(run.samples[early, 9] - mean).max() < 0.25 * apart


def test_a_measurement_delay_makes_a_steady_ramp_lag_less(drive) -> None:
    """At constant speed the loop sees theta(t - d): the true angle stands ahead by w d."""
    delay = 3.3e-4
    reference = _ramp(drive, 0.004)
    plain = _run(drive, {}, reference, 1.5)
    late = _run(drive, {"measurement_delay": {"delay_s": delay}}, reference, 1.5)
    speed = plain.signal("rotor_velocity_rad_per_s")[-1]
    ahead = late.signal("rotor_position_rad") - plain.signal("rotor_position_rad")
    assert ahead[-300:].mean() == pytest.approx(speed * delay, rel=1e-2)


def test_limits_are_the_lower_of_the_two(drive) -> None:
    """A limit effect caps the command; one above the nominal limit changes nothing."""
    fast = _ramp(drive, 0.04)
    capped = _run(drive, {"voltage_limit": {"voltage_v": 1.0}}, fast, 0.5)
    assert np.abs(capped.samples[:, VOLTAGE + 1]).max() == 1.0
    plain, wide = (_run(drive, e, fast, 0.5) for e in ({}, {"voltage_limit": {"voltage_v": 400.0}}))
    assert np.array_equal(plain.samples, wide.samples)


def test_a_voltage_limit_begins_near_its_value_without_a_recorded_voltage(drive) -> None:
    """What current and speed took of it tells the limit that acted to a tenth, as far as it was."""
    capped = _run(drive, {"voltage_limit": {"voltage_v": 1.0}}, _ramp(drive, 0.04), 0.5)
    evidence = SimpleNamespace(
        drive=drive,
        current_a=capped.signal("current_q_a"),
        rotor_speed_rad_s=capped.signal("rotor_velocity_rad_per_s"),
        voltage_v=np.full(len(capped.samples), np.nan),
    )
    starts = [one["voltage_v"] for one in CATALOGUE["voltage_limit"].starts(evidence)]
    assert min(starts) < 1.0 < 1.1 * max(starts)
    assert max(starts) < 1.1


def test_without_size_effects_change_nothing(drive) -> None:
    """Effects of zero size leave the run as it is, to the last bit."""
    reference = _ramp(drive, 0.01)
    plain = _run(drive, {}, reference, 0.4)
    nothing = {
        "cogging_torque": {"amplitude_nm": 0.0, "periods_per_rev": 6.0},
        "constant_load": {"force_n": 0.0},
        "inverter_dead_time": {"voltage_v": 0.0},
        "transmission_error": {"amplitude_rad": 0.0, "periods_per_screw_rev": 1.0},
    }
    assert np.array_equal(_run(drive, nothing, reference, 0.4).samples, plain.samples)


def test_several_effects_at_one_port_add_up(drive) -> None:
    """Two forces on the rod are one of their sum."""
    both = {
        "constant_load": {"force_n": 100.0},
        "periodic_disturbance": {
            "amplitude_n": 40.0,
            "frequency_hz": 1e-2,
            "phase_rad": 0.5 * math.pi,
        },
    }
    run = _run(drive, both, lambda i: (0.0, 0.0), 0.5)
    one = _run(drive, {"constant_load": {"force_n": 60.0}}, lambda i: (0.0, 0.0), 0.5)
    assert run.signal("current_q_a")[-1] == pytest.approx(one.signal("current_q_a")[-1], rel=1e-3)


def test_a_drive_file_holds_effects_there_and_back() -> None:
    """Effects in flat parameters come back the same, shape parameters with their defaults."""
    flat = drive_to_flat(load_drive("bench"))
    flat |= {"effects.rotor_coulomb_friction.coulomb_nm": 0.1}
    drive = drive_from_flat(flat, "test")
    assert drive.effects["rotor_coulomb_friction"]["coulomb_nm"] == 0.1
    assert drive_from_flat(drive_to_flat(drive), "test") == drive


@pytest.mark.parametrize(
    ("key", "value", "said"),
    [
        ("effects.cogging.amplitude_nm", 1.0, "did you mean cogging_torque"),
        ("effects.cogging_torque.amplitud", 1.0, "amplitude_nm, periods_per_rev, phase_rad"),
        ("effects.cogging_torque.amplitude_nm", -1.0, "expected a number from 0"),
        ("effects.cogging_torque.amplitude_nm", 1.0, "periods_per_rev is missing"),
    ],
)
def test_a_wrong_effect_is_refused_by_name(key, value, said) -> None:
    """Unknown effects, parameters and values are refused with the key and what was expected."""
    flat = drive_to_flat(load_drive("bench")) | {key: value}
    with pytest.raises(InputError, match="test: ") as error:
        drive_from_flat(flat, "test")
    assert said in str(error.value)
