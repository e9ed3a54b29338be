"""The compiled plant step against the exact piecewise-linear solution."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from ecyl_ros.drive.drive_file import load_drive
from ecyl_ros.drive.packed import pack
from ecyl_ros.drive.plant import initial_state, plant_step

from .exact_solution import ExactPlant

DURATION_S = 0.02
START = np.array([0.0, 12.0, 0.002, -9.0, 3.0])  # flanks meet at speed: many contacts on the way


def _drive(damping: float, stiffness: tuple[float, ...], breaks: tuple[float, ...]):
    drive = load_drive("bench")
    transmission = dataclasses.replace(
        drive.transmission, contact_damping=damping, stiffness=stiffness, stiffness_breaks=breaks
    )
    controller = dataclasses.replace(drive.controller, rate=1.0 / DURATION_S)
    return dataclasses.replace(drive, transmission=transmission, controller=controller)


def _stepped(drive, u_q: float, substeps: int, start: np.ndarray = START) -> np.ndarray:
    params = pack(drive, substeps=substeps)
    params["pole_pairs"] = 0.0  # no cross-coupling: the exact solution needs a linear plant
    state = initial_state()
    state[[0, 1, 2, 3, 5]] = start
    plant_step(state, 0.0, u_q, params)
    return state[[0, 1, 2, 3, 5]]


CASES = {
    "damped contact": (0.15, (6498.0,), ()),
    "undamped contact": (0.0, (6498.0,), ()),
    "two segments": (0.05, (3000.0, 9000.0), (4.0,)),
}


@pytest.mark.parametrize("case", CASES)
def test_error_falls_at_fourth_order_through_contacts(case: str) -> None:
    """Halving the step divides the error by 2^4 although flanks meet and part on the way."""
    drive = _drive(*CASES[case])
    exact, contacts = ExactPlant(drive).advance(START, 5.0, DURATION_S)
    assert contacts >= 6
    scale = np.array([1.0, 100.0, 1.0, 100.0, 10.0])
    substeps = np.array([1000, 2000, 4000, 8000])
    errors = [np.abs((_stepped(drive, 5.0, n) - exact) / scale).max() for n in substeps]
    slope = np.polyfit(np.log(1.0 / substeps), np.log(errors), 1)[0]
    assert 3.6 < slope < 4.4, errors
    assert errors[-1] < 5e-9


def test_free_flight_is_exact_to_rounding() -> None:
    """With no contact within reach the plant is a rotor, a load and an RL circuit apart."""
    drive = _drive(0.15, (6498.0,), ())
    transmission = dataclasses.replace(drive.transmission, backlash=1.0)
    drive = dataclasses.replace(drive, transmission=transmission)
    start = np.array([0.0, 2.0, 0.002, -1.0, 3.0])
    exact, contacts = ExactPlant(drive).advance(start, 1.0, DURATION_S)
    assert contacts == 0
    np.testing.assert_allclose(_stepped(drive, 1.0, 2000, start), exact, rtol=1e-9)


@pytest.mark.parametrize("straightness", [None, 0.0, 1.0])
def test_automatic_substeps_stay_under_the_sensor_noise(straightness) -> None:
    """The step chosen by itself is as good as one eight times finer, measured in noise.

    So it is where a dead time turns its sign over 10 mA, 130 ohm to the current there.
    """
    from ecyl_ros.drive.engine import simulate
    from ecyl_ros.drive.packed import choose_substeps
    from ecyl_ros.drive.reference.sine import Sine

    drive = load_drive("bench")
    sharp = {"voltage_v": 1.3, "transition_a": 0.01, "straightness": straightness}
    effects = {} if straightness is None else {"inverter_dead_time": sharp}
    drive = dataclasses.replace(drive, effects=effects)
    quiet = dataclasses.replace(drive, sensors=type(drive.sensors)())
    sine = Sine(amplitude=5e-3, frequency=1.0)
    count = choose_substeps(drive)
    runs = [
        simulate(quiet, lambda i: sine.sample(i / drive.sample_rate), 2.0, substeps=n)
        for n in (count, 8 * count)
    ]
    noise = {
        "rotor_position_rad": drive.sensors.rotor_position_noise,
        "rotor_velocity_rad_per_s": drive.sensors.rotor_velocity_noise,
        "current_q_a": drive.sensors.current_noise,
        "rod_position_m": drive.sensors.rod_position_noise,
    }
    for name, std in noise.items():
        difference = np.abs(runs[0].signal(name) - runs[1].signal(name)).max()
        assert difference < 0.1 * std, name


@pytest.mark.parametrize(
    ("effect", "parameter", "part", "constant", "factor"),
    [
        ("stiffness_error", "stiffness_nm_per_rad", "transmission", "stiffness", 12.0),
        ("rotor_inertia_error", "inertia_kg_m2", "motor", "rotor_inertia", 0.1),
        ("load_inertia_error", "inertia_kg_m2", "load", "inertia", 0.1),
        ("resistance_error", "resistance_ohm", "motor", "resistance", 60.0),
    ],
)
def test_an_effect_on_a_constant_takes_the_steps_of_a_drive_that_has_it(
    effect: str, parameter: str, part: str, constant: str, factor: float
) -> None:
    """A coupling that an effect makes twelve times as stiff is stepped as finely as one whose file
    says so; a softer one no more coarsely than the file's own."""
    drive = load_drive("bench")
    before = pack(drive)["substeps"][0]
    stated = getattr(getattr(drive, part), constant)
    value = (stated[0] if isinstance(stated, tuple) else stated) * factor
    true = (value,) if isinstance(stated, tuple) else value
    machine = dataclasses.replace(
        drive, **{part: dataclasses.replace(getattr(drive, part), **{constant: true})}
    )
    by_effect = dataclasses.replace(drive, effects={effect: {parameter: value}})
    assert pack(by_effect)["substeps"][0] == pack(machine)["substeps"][0] > 1.5 * before
    other_way = {parameter: value / factor**2}
    slower = dataclasses.replace(drive, effects={effect: other_way})
    assert pack(slower)["substeps"][0] == before
