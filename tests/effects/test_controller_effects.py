"""Effects of a controller that is not the nominal one, against a cascade written in Python."""

from __future__ import annotations

import dataclasses
import itertools
import math

import numpy as np
import pytest

from ecyl_ros.drive.drive_file import load_drive
from ecyl_ros.drive.engine import VOLTAGE, simulate
from ecyl_ros.drive.packed import pack
from ecyl_ros.drive.parameters import Gains, PositionGains, SensorParameters
from ecyl_ros.effects.catalogue import CATALOGUE

from ..drive.python_cascade import PythonCascade, commands_of, plain_numbers

# Effect, its parameter, a true value, and what the Python cascade is told for it.
CASES = [
    ("position_gain_error", "kp_per_s", 30.0, {"position": (30.0, 0.0, 0.0)}),
    ("position_integral_error", "ki_per_s2", 200.0, {"position": (40.0, 200.0, 0.0)}),
    ("speed_gain_error", "kp_a_s_per_rad", 0.6, {"speed": (0.6, 24.0)}),
    ("speed_integral_error", "ki_a_per_rad", 60.0, {"speed": (0.8, 60.0)}),
    ("current_gain_error", "kp_v_per_a", 4.0, {"current": (4.0, 2260.0)}),
    ("current_integral_error", "ki_v_per_a_s", 6000.0, {"current": (7.0, 6000.0)}),
    ("feed_constant_error", "error", 0.01, {"rod_per_rotor": 0.0202 / (2.0 * math.pi * 2.16)}),
    ("velocity_feedforward_error", "share", 0.7, {"velocity_feedforward": 0.7}),
    (
        "acceleration_feedforward_error",
        "gain_a_s2_per_rad",
        2e-3,
        {"acceleration_feedforward": 2e-3},
    ),
    ("command_filter", "time_constant_s", 4e-3, {"setpoint_filter": 4e-3}),
    ("current_command_filter", "time_constant_s", 4e-4, {"current_command_filter": 4e-4}),
    ("feedback_filter", "time_constant_s", 5e-4, {"speed_filter": 5e-4}),
]
EFFECTS = [name for name, *_ in CASES]
SETTINGS = [name for name in EFFECTS if name != "feed_constant_error"]  # whose sizes are anything


def _bench(**controller):
    """The bench drive without noise, recorded at every tick."""
    drive = load_drive("bench")
    return dataclasses.replace(
        drive,
        sensors=SensorParameters(),
        telemetry_rate=drive.controller.rate,
        controller=dataclasses.replace(drive.controller, **controller),
    )


def _swinging(drive, effects, duration_s=0.3):
    """Samples of a run on 1 mm at 6 Hz."""
    rate = 2.0 * math.pi * 6.0

    def reference(index):
        time = index / drive.sample_rate
        return 1e-3 * (1.0 - math.cos(rate * time)), 1e-3 * rate * math.sin(rate * time)

    return simulate(dataclasses.replace(drive, effects=effects), reference, duration_s).samples


def _lag_s(drive, effects, speed_m_s=0.01):
    """How long the rod stays behind a reference at constant speed, s."""

    def reference(index):
        time = index / drive.sample_rate
        if time < 0.2:
            x = time / 0.2
            return speed_m_s * 0.2 * (x**3 - 0.5 * x**4), speed_m_s * (3 * x**2 - 2 * x**3)
        return speed_m_s * (time - 0.1), speed_m_s

    run = simulate(dataclasses.replace(drive, effects=effects), reference, 1.6)
    per = drive.transmission.rod_per_rotor
    wanted = reference(len(run.samples) - 1)[0]
    return (wanted - per * run.signal("rotor_position_rad")[-1]) / speed_m_s


@pytest.mark.parametrize(("name", "parameter", "value", "told"), CASES, ids=EFFECTS)
def test_the_controller_commands_what_one_with_the_true_value_would(
    name, parameter, value, told
) -> None:
    """Every voltage of a run with the effect is the Python cascade's with the true value; with the
    nominal value that cascade commands something else."""
    drive = _bench()
    samples = _swinging(drive, {name: {parameter: value}})
    numbers = plain_numbers(drive)
    true = np.array(commands_of(PythonCascade(**numbers | told), samples))[:, 1]
    nominal = np.array(commands_of(PythonCascade(**numbers), samples))[:, 1]
    recorded = samples[:, VOLTAGE + 1]
    largest = np.abs(recorded).max()
    assert np.abs(recorded - true).max() < 1e-9 * largest
    assert np.abs(recorded - nominal).max() > 1e-2 * largest


@pytest.mark.parametrize(("name", "parameter", "value", "told"), CASES, ids=EFFECTS)
def test_at_its_neutral_value_an_effect_changes_nothing(name, parameter, value, told) -> None:
    """With the nominal model's own value a run is the nominal one, to the last bit."""
    drive = _bench()
    neutral = CATALOGUE[name].neutral(drive)
    plain, neutral_run = (
        _swinging(drive, effects, 0.1) for effects in ({}, {name: {parameter: neutral}})
    )
    assert np.array_equal(plain, neutral_run)


@pytest.mark.parametrize(
    ("effects", "lag_s"),
    [
        ({}, 1.0 / 40.0),
        ({"position_gain_error": {"kp_per_s": 32.0}}, 1.0 / 32.0),
        ({"velocity_feedforward_error": {"share": 0.6}}, 0.4 / 40.0),
        # A sampled low-pass stays behind a ramp by kept / (1 - kept) ticks.
        (
            {"command_filter": {"time_constant_s": 6e-3}},
            1.0 / 40.0 + 1e-4 / math.expm1(1e-4 / 6e-3),
        ),
        ({"position_integral_error": {"ki_per_s2": 400.0}}, 0.0),
    ],
)
def test_the_lag_behind_a_ramp_is_that_of_the_position_loop(effects, lag_s) -> None:
    """At constant speed the drive stays (1 - share) / kp and the filter's delay behind; an
    integral in the position loop leaves nothing."""
    assert _lag_s(_bench(), effects) == pytest.approx(lag_s, rel=1e-3, abs=2e-5)


def test_acceleration_feedforward_of_the_inertia_leaves_the_speed_loop_nothing_to_do() -> None:
    """Fed forward with velocity and J / K_t of acceleration, a drive without friction and backlash
    stays on its reference; without it, it does not."""
    drive = _bench()
    drive = dataclasses.replace(
        drive,
        motor=dataclasses.replace(drive.motor, viscous_friction=0.0),
        load=dataclasses.replace(drive.load, viscous_friction=0.0),
        transmission=dataclasses.replace(drive.transmission, backlash=0.0),
    )
    inertia = drive.motor.rotor_inertia + drive.load.inertia
    push = {"gain_a_s2_per_rad": inertia / drive.motor.torque_constant}
    forward = {"velocity_feedforward_error": {"share": 1.0}}
    errors = []
    for effects in (forward, {**forward, "acceleration_feedforward_error": push}):
        samples = _swinging(drive, effects)
        rotor = samples[:, 4] * drive.transmission.rod_per_rotor
        errors.append(np.abs(samples[1000:, 0] - rotor[1000:]).max())
    assert errors[1] < 0.05 * errors[0]


@pytest.mark.parametrize("name", SETTINGS)
@pytest.mark.parametrize("features", ["plain", "all"])
def test_fits_begin_at_possible_values_off_the_nominal_one(name, features) -> None:
    """Each effect has several starts within its bounds, apart from each other and from the nominal
    value by 10 % or more, whether the nominal model has the thing or not."""
    changes = {}
    if features == "all":
        changes = {
            "position": PositionGains(kp=40.0, ki=20.0),
            "velocity_feedforward": 1.0,
            "acceleration_feedforward": 2e-3,
            "setpoint_filter": 4e-3,
            "current_command_filter": 4e-4,
            "speed_filter": 5e-4,
        }
    drive = _bench(**changes)
    effect = CATALOGUE[name]
    (quantity,) = effect.parameters
    neutral = effect.neutral(drive)
    assert (neutral > 0.0) or features == "plain"
    begun = [one[quantity.name] for one in effect.starts(_Evidence(drive))]
    assert len(begun) >= 4
    assert all(quantity.low < value < quantity.high for value in begun)
    values = sorted([*begun, *([neutral] if neutral else [])])
    assert all(late > 1.1 * early for early, late in itertools.pairwise(values))


@dataclasses.dataclass
class _Evidence:
    drive: object


@dataclasses.dataclass
class _Moved:
    drive: object
    rotor_speed_rad_s: np.ndarray
    rotor_speed_error_rad_s: np.ndarray


def test_a_feed_constant_is_begun_where_the_rotors_speed_puts_it() -> None:
    """A rotor 2 % slower than the model's: the feed constant is 1/0.98 of the sheet's; with the
    loop closed on the rod it cannot be told, and no fit begins."""
    model = np.sin(np.linspace(0.0, 20.0, 2000))
    begun = CATALOGUE["feed_constant_error"].starts(_Moved(_bench(), 0.98 * model, -0.02 * model))
    assert begun[0]["error"] == pytest.approx(1.0 / 0.98 - 1.0)
    on_rod = _Moved(_bench(feedback="rod"), model, 0.0 * model)
    assert CATALOGUE["feed_constant_error"].starts(on_rod) == []


def test_no_fit_begins_for_a_speed_loop_that_is_not_there() -> None:
    """Without speed loop its gains and the velocity feedforward have no starts; the others do."""
    drive = _bench(
        structure="position_to_current",
        position=PositionGains(kp=32.0, ki=0.0, kd=0.8),
        speed=Gains(kp=0.0),
    )
    without = {name for name in SETTINGS if not CATALOGUE[name].starts(_Evidence(drive))}
    assert without == {"speed_gain_error", "speed_integral_error", "velocity_feedforward_error"}


def test_in_series_form_a_wrong_gain_takes_its_integral_along() -> None:
    """kp (1 + ki / s): another kp changes the parallel ki in proportion, unless a true integral
    gain is given beside it, in whatever order."""
    drive = _bench(form="series", speed=Gains(kp=0.8, ki=30.0))
    gain, integral = {"kp_a_s_per_rad": 0.4}, {"ki_a_per_rad": 50.0}
    for effects, ki in (
        ({"speed_gain_error": gain}, 12.0),
        ({"speed_gain_error": gain, "speed_integral_error": integral}, 50.0),
        ({"speed_integral_error": integral, "speed_gain_error": gain}, 50.0),
    ):
        record = pack(dataclasses.replace(drive, effects=effects))
        assert record["speed_kp"][0] == 0.4
        assert record["speed_ki"][0] == pytest.approx(ki)
    assert CATALOGUE["speed_integral_error"].neutral(drive) == pytest.approx(24.0)
