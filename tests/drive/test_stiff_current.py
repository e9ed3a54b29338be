"""The current through an inverter's dead time against SciPy's stiff solver."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from ecyl_ros.drive.drive_file import load_drive
from ecyl_ros.drive.packed import choose_substeps, pack
from ecyl_ros.drive.plant import initial_state, plant_step

LOST_V, RATE_HZ = 17.0, 4000.0


def _drive(transition: float, straightness: float):
    """The bench drive with its load out of reach: a rotor, a winding and an inverter."""
    drive = load_drive("bench")
    dead_time = {"voltage_v": LOST_V, "transition_a": transition, "straightness": straightness}
    return dataclasses.replace(
        drive,
        transmission=dataclasses.replace(drive.transmission, backlash=100.0),
        controller=dataclasses.replace(drive.controller, rate=RATE_HZ),
        effects={"inverter_dead_time": dead_time},
    )


def _lost(current: float, transition: float, straightness: float) -> float:
    share = current / transition
    line = min(max(math.tanh(1.0) * share, -1.0), 1.0)
    return LOST_V * ((1.0 - straightness) * math.tanh(share) + straightness * line)


def _truth(drive, start: np.ndarray, voltages: np.ndarray, loss) -> np.ndarray:
    """Rotor angle, speed and current after each tick, float64[ticks, 3]."""
    motor = drive.motor

    def slopes(time, y, u):
        torque = motor.torque_constant * y[2] - motor.viscous_friction * y[1]
        winding = u - loss(y[2]) - motor.resistance * y[2] - motor.back_emf_constant * y[1]
        return [y[1], torque / motor.rotor_inertia, winding / motor.inductance]

    states = []
    for u in voltages:
        solved = solve_ivp(
            slopes, (0.0, 1.0 / RATE_HZ), start, "Radau", args=(u,), rtol=1e-10, atol=1e-12
        )
        start = solved.y[:, -1]
        states.append(start)
    return np.array(states)


def _stepped(drive, start: np.ndarray, voltages: np.ndarray, substeps: int) -> np.ndarray:
    params = pack(drive, substeps=substeps)
    params["pole_pairs"] = 0.0
    state = initial_state()
    state[[0, 1, 5]] = start
    states = []
    for u in voltages:
        plant_step(state, 0.0, u, params)
        states.append(state[[0, 1, 5]])
    return np.array(states)


@pytest.mark.parametrize("transition", [1e-4, 0.005, 0.05])
@pytest.mark.parametrize("straightness", [0.0, 1.0])
def test_coarse_steps_through_a_dead_time_follow_a_stiff_solver(
    transition: float, straightness: float
) -> None:
    """One step a tick stays within 1 % of the transition and 0.2 per mille of the largest current.

    A tick lasts up to 10 000 time constants of the current within the transition. The voltages
    hold the current there, drive it through and leave it far out.
    """
    drive = _drive(transition, straightness)
    voltages = np.repeat([3.0, 25.0, -16.0, 16.5, -40.0, 0.0, 17.5], 8)
    start = np.array([0.0, 1.0, 0.4])
    truth = _truth(drive, start, voltages, lambda i: _lost(i, transition, straightness))
    assert np.abs(truth[:, 2]).max() > 1.0
    assert np.abs(truth[:, 2]).min() < 0.5 * transition
    found = _stepped(drive, start, voltages, 1)
    off = np.abs(found[:, 2] - truth[:, 2])
    assert off.max() < 0.01 * transition + 2e-4 * np.abs(truth[:, 2]).max()
    assert np.abs(found[:, 1] - truth[:, 1]).max() < 1e-3 * np.ptp(truth[:, 1])


def test_a_voltage_that_is_not_lost_leaves_the_classical_step() -> None:
    """A dead time of next to 0 V gives what a drive without it gives, to the step's own error."""
    drive = load_drive("bench")
    nothing = {"inverter_dead_time": {"voltage_v": 1e-12}}
    runs = []
    for effects in ({}, nothing):
        params = pack(dataclasses.replace(drive, effects=effects))
        state = initial_state()
        state[[1, 5]] = 3.0, 0.5
        for u in np.linspace(-5.0, 5.0, 200):
            plant_step(state, 0.0, u, params)
        runs.append(state[:6].copy())
    np.testing.assert_allclose(runs[1], runs[0], rtol=1e-5, atol=1e-8)


def test_dead_time_costs_no_sub_steps() -> None:
    """However sharp the loss turns, a tick is taken in as many sub-steps as without it."""
    drive = _drive(1e-4, 0.0)
    assert choose_substeps(drive) == choose_substeps(dataclasses.replace(drive, effects={}))
