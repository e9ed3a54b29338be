"""What all torques of a drive are counted in is told by its data sheet, not by any motion."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from ecyl_ros.drive.drive_file import load_drive
from ecyl_ros.drive.engine import simulate
from ecyl_ros.drive.reference.sine import Sine
from ecyl_ros.drive.telemetry import simulation_recording
from ecyl_ros.gap.fit.fit import Fit, Fitter
from ecyl_ros.gap.fit.torque_scale import TorqueScale, of_torque
from ecyl_ros.gap.judge.intervals import intervals
from ecyl_ros.gap.replay.replay import Replay

DRIVE = load_drive("bench")
TRUE = {"load_coulomb_friction": {"coulomb_nm": 0.15}, "constant_load": {"force_n": 40.0}}


@pytest.fixture(scope="module")
def fitter() -> Fitter:
    """Of the bench drive with friction and a load, which rests and reverses."""
    motion = Sine(amplitude=3e-3, frequency=1.0)
    drive = dataclasses.replace(DRIVE, effects=TRUE)
    run = simulate(drive, lambda i: motion.sample(i / drive.sample_rate), 2.5)
    replay = Replay(simulation_recording(run, drive), DRIVE, "recording")
    return Fitter(replay, replay.held_out())


@pytest.fixture(scope="module")
def fitted(fitter) -> Fit:
    """Both effects and the sheet, near the truth."""
    return fitter.fit(fitter.evaluate(TRUE), steps=2)


def scaled(by: float) -> dict[str, dict[str, float]]:
    """The true effects with all that is counted in N or N m larger."""
    return {name: {key: by * value for key, value in given.items()} for name, given in TRUE.items()}


def test_no_motion_shows_the_scale_of_all_torques(fitter) -> None:
    """All torques 3 % larger leave the same of the recording, to a millionth of a noise floor;
    one of them left behind does not."""
    sheet = fitter.sheet
    pulls = np.where([of_torque(one) for one in sheet.units], math.log(1.03) / sheet.relative, 0.0)
    before, after = fitter.evaluate(TRUE), fitter.evaluate(scaled(1.03), pulls)
    assert np.abs(before.gap - after.gap).max() < 1e-6
    other = fitter.evaluate(TRUE, pulls)
    assert np.abs(before.gap - other.gap).max() > 1.0


def test_derivatives_hold_nothing_along_it(fitter, fitted) -> None:
    """The derivatives of a fit, added up along the scale, are zero, as those of the gap are."""
    scale = TorqueScale.of(
        fitted.names, fitted.coordinates, fitted.pulled, fitter.sheet, fitter.replay.nominal
    )
    assert scale is not None
    values = [one.of(fitted.values[one.effect][one.quantity.name]) for one in fitted.coordinates]
    point = np.concatenate([values, fitted.pulls[list(fitted.pulled)]])
    along = scale.at(point)
    assert np.abs(along @ fitted.jacobian).max() < 1e-3 * np.abs(fitted.jacobian).max()
    assert np.linalg.norm(along) == pytest.approx(1.0)


def test_what_is_known_of_it_comes_from_the_sheet(fitter, fitted) -> None:
    """Seven constants of a tolerance of 2 % hold one factor to 2 % over the root of seven: so wide
    are the intervals of friction, load and torque constant, whatever the flanks do."""
    spans, pulls = intervals(fitted, fitter)
    torques = sum(of_torque(one) for one in fitter.sheet.units)
    width = 0.02 / math.sqrt(torques)
    row = fitter.sheet.index("motor.torque_constant")
    assert 0.02 * pulls[row] > 0.9 * width
    for key in (("load_coulomb_friction", "coulomb_nm"), ("constant_load", "force_n")):
        low, high = spans[key]
        assert (high - low) / (high + low) > 0.9 * width


def test_a_torque_that_is_known_holds_the_scale(fitter) -> None:
    """With an exact torque constant, or a friction in the drive file, there is no such freedom."""
    rows = [
        row for row in range(len(fitter.sheet)) if fitter.sheet.keys[row] != "motor.torque_constant"
    ]
    assert TorqueScale.of((), (), rows, fitter.sheet, DRIVE) is None
    rubbing = dataclasses.replace(DRIVE, effects=TRUE)
    every = range(len(fitter.sheet))
    assert TorqueScale.of((), (), list(every), fitter.sheet, rubbing) is None
    assert TorqueScale.of((), (), list(every), fitter.sheet, DRIVE) is not None
