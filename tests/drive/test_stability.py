"""The check of the sampled loop, against what simulation does."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from ecyl_ros.drive.drive_file import load_drive
from ecyl_ros.drive.engine import simulate
from ecyl_ros.drive.parameters import Gains, PositionGains
from ecyl_ros.drive.reference.sine import Sine
from ecyl_ros.drive.stability import (
    at_rate,
    check_stability,
    closed_loop_matrix,
    is_stable,
    smallest_stable_rate,
)
from ecyl_ros.errors import InputError


def _with(drive, **changes):
    return dataclasses.replace(drive, controller=dataclasses.replace(drive.controller, **changes))


def _runs_away(drive) -> bool:
    """The rotor moves far faster than the reference asks (0.085 rad/s): growth, or the limit
    cycle across the clearance that growth ends in."""
    sine = Sine(amplitude=2e-5, frequency=1.0)
    with np.errstate(all="ignore"):
        run = simulate(drive, lambda i: sine.sample(i / drive.sample_rate), 0.5)
    speed = run.signal("rotor_velocity_rad_per_s")[250:]
    return not np.isfinite(speed).all() or np.abs(speed).max() > 0.5


def test_paper_gains_need_between_50_and_100_khz() -> None:
    """Without delay the paper's gains are unstable at 50 kHz and stable at 100 kHz."""
    drive = load_drive("paper")
    assert is_stable(drive)
    assert not is_stable(at_rate(drive, 50e3))
    assert 50e3 < smallest_stable_rate(drive) < 100e3
    assert not _runs_away(drive)
    assert _runs_away(at_rate(drive, 50e3))


def test_one_tick_of_delay_takes_the_paper_gains_to_500_khz() -> None:
    """With one sample of delay 200 kHz diverges and 500 kHz holds."""
    drive = _with(load_drive("paper"), delay_ticks=1)
    assert 200e3 < smallest_stable_rate(drive) < 500e3
    assert _runs_away(at_rate(drive, 200e3))
    assert not _runs_away(at_rate(drive, 500e3))


@pytest.mark.parametrize("delay", [0, 1, 2])
def test_smallest_rate_is_where_the_loop_turns(delay: int) -> None:
    """Without clearance a run just below the smallest stable rate runs away, above it holds."""
    drive = _with(
        load_drive("bench"), delay_ticks=delay, current_limit=np.inf, voltage_limit=np.inf
    )
    transmission = dataclasses.replace(drive.transmission, backlash=0.0)
    drive = dataclasses.replace(drive, transmission=transmission)
    least = smallest_stable_rate(drive)
    assert _runs_away(at_rate(drive, 0.95 * least))
    assert not _runs_away(at_rate(drive, 1.05 * least))


def test_rod_feedback_on_the_soft_spring_has_no_stable_rate() -> None:
    """Closed on the rod, the undamped load on 1.89 N m/rad diverges at any rate."""
    drive = _with(load_drive("paper"), feedback="rod")
    assert smallest_stable_rate(drive) is None
    with pytest.raises(InputError, match="no rate makes it stable"):
        check_stability(drive, "file.yaml")


def test_refusal_names_the_smallest_rate() -> None:
    """The error line names the file, the key and a rate that would do."""
    drive = at_rate(load_drive("paper"), 20e3)
    with pytest.raises(InputError, match=r"file\.yaml: controller\.rate = 20000 Hz") as caught:
        check_stability(drive, "file.yaml")
    named = float(str(caught.value).split("at least ")[1].split(" Hz")[0])
    assert is_stable(at_rate(drive, named))


EXTRAS = {
    "plain": {},
    "filters": {"speed_filter": 5e-4, "current_command_filter": 3e-4},
    "differences": {"speed_source": "differences", "position": PositionGains(kp=40.0, kd=0.1)},
    "no speed loop": {
        "structure": "position_to_current",
        "position": PositionGains(kp=32.0, ki=100.0, kd=0.8),
        "speed": Gains(kp=0.0),
        "speed_source": "differences",
        "speed_filter": 5e-4,
        "current_command_filter": 3e-4,
        "setpoint_filter": 1e-2,
        "acceleration_feedforward": 2e-3,
    },
}


@pytest.mark.parametrize("extra", EXTRAS)
def test_linearisation_matches_the_compiled_loop(extra: str) -> None:
    """One tick of the compiled loop near rest moves as the matrix says, in contact and free,
    whatever the cascade remembers; what acts on the reference alone is not in it."""
    from ecyl_ros.drive.cascade import (
        CURRENT,
        LAST_ANGLE,
        SPEED,
        cascade_step,
        initial_cascade_state,
    )
    from ecyl_ros.drive.packed import pack
    from ecyl_ros.drive.plant import MEASURED, initial_state, measure, plant_step

    drive = _with(load_drive("bench"), **EXTRAS[extra])
    drive = dataclasses.replace(drive, sensors=type(drive.sensors)())
    control = drive.controller
    p = pack(drive, substeps=50)
    used = [
        *([LAST_ANGLE] if control.speed_source == "differences" else []),
        *([SPEED] if control.speed_filter else []),
        *([CURRENT] if control.current_command_filter else []),
    ]
    half = drive.transmission.backlash / 2
    for stiffness, twist, keep in ((6498.0, half + 1e-4, [0, 1, 2, 3, 5]), (0.0, 0.0, [0, 1, 5])):
        base = initial_state()
        base[[0, 1, 3, 5]] = twist, 0.1, 0.1, 0.2

        def tick(plant: np.ndarray, cascade: tuple, keep: list[int]) -> np.ndarray:
            plant = plant.copy()
            cascade = (cascade[0].copy(), *cascade[1:])
            measured, voltage = np.zeros(len(MEASURED)), np.zeros(2)
            measure(plant, 0, p, measured)
            cascade_step(cascade, 0.0, 0.0, measured, p, voltage)
            plant_step(plant, 0.0, voltage[1], p)
            memory = cascade[2][used] if used else []
            return np.concatenate([plant[keep], cascade[0], memory])

        matrix = closed_loop_matrix(drive, stiffness)
        states = len(keep)
        assert len(matrix) == states + 3 + len(used)
        measured_matrix = np.zeros_like(matrix)
        for column in range(len(matrix)):
            ends = []
            for sign in (1.0, -1.0):
                plant, cascade = base.copy(), initial_cascade_state(p)
                if used:
                    cascade[2][:] = 0.0
                    cascade[2][LAST_ANGLE] = twist
                if column < states:
                    plant[keep[column]] += sign * 1e-7
                elif column < states + 3:
                    cascade[0][column - states] += sign * 1e-7
                else:
                    cascade[2][used[column - states - 3]] += sign * 1e-7
                ends.append(tick(plant, cascade, keep))
            measured_matrix[:, column] = (ends[0] - ends[1]) / 2e-7
        np.testing.assert_allclose(measured_matrix, matrix, rtol=1e-4, atol=1e-3)


@pytest.mark.parametrize("key", ["speed_filter", "current_command_filter"])
def test_a_filter_in_the_loop_is_refused_where_it_runs_away(key: str) -> None:
    """With ever longer filters the sampled loop turns unstable where simulation does."""
    drive = load_drive("bench")
    drive = _with(drive, current_limit=np.inf, voltage_limit=np.inf)
    transmission = dataclasses.replace(drive.transmission, backlash=0.0)
    drive = dataclasses.replace(drive, transmission=transmission)
    low, high = 1e-5, 0.3
    assert is_stable(_with(drive, **{key: low})) and not is_stable(_with(drive, **{key: high}))
    while high / low > 1.01:
        middle = (low * high) ** 0.5
        low, high = (middle, high) if is_stable(_with(drive, **{key: middle})) else (low, middle)
    with pytest.raises(InputError, match="expected shorter filters"):
        check_stability(_with(drive, **{key: 0.3}), "f")
    assert _runs_away(_with(drive, **{key: 1.5 * high}))
    assert not _runs_away(_with(drive, **{key: 0.7 * low}))
