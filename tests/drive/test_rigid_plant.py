"""The step of a rigid machine against closed forms and scipy."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from ecyl_ros.drive.rigid.machine import Machine
from ecyl_ros.drive.rigid.model import Acting
from ecyl_ros.drive.rigid.packed import model_of, plant_of
from ecyl_ros.drive.rigid.plant import along

MASS = 20.0
FILE = Machine(
    kind="rigid", output="linear", actuation="force", gain=1.0, inertia=MASS, coulomb=4.0
)


def test_a_sliding_mass_stops_where_friction_has_taken_its_energy() -> None:
    """From v it slides M v^2 / (2 F), whatever the step, and then stays to the last bit."""
    plant = plant_of(model_of(dataclasses.replace(FILE, coulomb=8.0), True))
    for h in (1e-3, 2.3e-4):
        n = int(1.0 / h)
        position, speed = along(plant, 0.0, 0.0, 0.1, np.zeros(n), np.zeros(n), np.zeros((n, 2)), h)
        assert position[-1] == pytest.approx(MASS * 0.01 / 16.0, rel=2e-3)
        assert speed[-1] == 0.0 and position[-1] == position[-50]


@pytest.mark.parametrize("values", [{"coefficient": 0.4}, {"inertia": 0.4 * MASS}])
def test_friction_in_proportion_to_acceleration_is_an_inertia_that_brakes(values) -> None:
    """A level of 0.4 of what accelerates: effort F accelerates M by F / (1.4 M)."""
    rubbing = Acting("load_dependent_friction", values)
    machine = dataclasses.replace(FILE, coulomb=0.0, effects=(rubbing,), effects_unit="N")
    n, h = 2000, 1e-4
    plant = plant_of(model_of(machine, True))
    _, speed = along(plant, 0.0, 0.0, 0.1, np.full(n, 12.0), np.zeros(n), np.zeros((n, 2)), h)
    assert np.gradient(speed, h)[n // 2] == pytest.approx(12.0 / (1.4 * MASS), rel=1e-6)


def test_friction_holds_up_to_its_level_and_no_further() -> None:
    """A load below the friction level moves nothing; above, it accelerates by what is over."""
    plant = plant_of(model_of(dataclasses.replace(FILE, coulomb=8.0), True))
    h, n = 1e-3, 1000
    still, _ = along(plant, 0.0, 0.3, 0.0, np.full(n, 7.99), np.zeros(n), np.zeros((n, 2)), h)
    assert np.all(still == 0.3)
    _, speed = along(plant, 0.0, 0.3, 0.0, np.full(n, -9.0), np.zeros(n), np.zeros((n, 2)), h)
    assert speed[-1] == pytest.approx(-1.0 / MASS * h * (n - 1), rel=1e-9)


SHAPED = dataclasses.replace(
    FILE,
    coulomb=0.0,
    viscous=30.0,
    constant=2.0,
    stiffness=900.0,
    effects=(
        Acting("cogging_torque", {"amplitude": 5.0, "wave": 600.0, "phase": 0.3}),
        Acting("torque_ripple", {"fraction": 0.2, "wave": 150.0, "phase": -1.0}),
        Acting("periodic_disturbance", {"amplitude": 3.0, "frequency": 4.0, "phase": 1.1}),
        Acting("spring_load", {"stiffness": 200.0, "rest": 0.02}),
    ),
)


def test_the_step_agrees_with_scipy_and_is_of_second_order() -> None:
    """Cogging, ripple, spring, disturbance: LSODA's solution, its error falling as h squared."""

    def slope(t: float, s: np.ndarray) -> list[float]:
        q, v = s
        force = 12.0 * (1.0 - 0.2 * np.sin(150.0 * q - 1.0)) - 30.0 * v - 2.0 - 900.0 * q
        force -= 200.0 * (q - 0.02) + 5.0 * np.sin(600.0 * q + 0.3)
        force -= 3.0 * np.sin(2.0 * np.pi * 4.0 * t + 1.1)
        return [v, force / MASS]

    plant = plant_of(model_of(SHAPED, True))
    exact = solve_ivp(slope, (0.0, 2.0), [0.0, 0.1], "LSODA", rtol=1e-11, atol=1e-14)
    errors = []
    for h in (1e-3, 5e-4):
        n = round(2.0 / h) + 1
        position, _ = along(
            plant, 0.0, 0.0, 0.1, np.full(n, 12.0), np.zeros(n), np.zeros((n, 2)), h
        )
        errors.append(abs(position[-1] - exact.y[0, -1]))
    assert errors[1] < 1e-6
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.25)
