"""Noise that goes round the loop, and what it does to a drive that friction holds at rest."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from sheets import exact
from small_field import without_all_but

from ecyl_ros.drive.engine import simulate
from ecyl_ros.drive.reference.moves import plan_move
from ecyl_ros.drive.telemetry import simulation_recording
from ecyl_ros.effects.catalogue import CATALOGUE
from ecyl_ros.gap.compete.earn import at_noise, surely_at_noise
from ecyl_ros.gap.diagnose import diagnose
from ecyl_ros.gap.fit.fit import Fitter
from ecyl_ros.gap.fit.robust import misfit
from ecyl_ros.gap.replay.replay import Replay
from ecyl_ros.gap.split import held_out
from ecyl_ros.recording.signals import Recording

DRIVE = exact("bench")
FRICTION = {"rotor_coulomb_friction": {"coulomb_nm": 0.1}}
SECONDS = 7.5


def _with_rests(effects, noise: float = 1.0) -> Recording:
    """A run of the emulated drive, sensor noise in its loop: moves of 0.3 s, rests of 1.2 s."""
    rate = DRIVE.sample_rate
    wanted = np.zeros((round(SECONDS * rate) + 1, 2))
    place = 0.0
    for number, goal in enumerate((0.004, -0.003, 0.006, -0.002)):
        leg = plan_move(place, goal, 0.05, 1.0, 50.0)
        begin = round((0.5 + 1.5 * number) * rate)
        wanted[begin:, 0] = goal
        for index in range(round(leg.duration * rate)):
            position, velocity, _ = leg.at_time(index / rate)
            wanted[begin + index] = position[0], velocity[0]
        place = goal
    stated = {
        one.name: noise * getattr(DRIVE.sensors, one.name)
        for one in dataclasses.fields(DRIVE.sensors)
        if one.name.endswith("_noise")
    }
    sensors = dataclasses.replace(DRIVE.sensors, **stated, noise_seed=11)
    drive = dataclasses.replace(DRIVE, effects=effects, sensors=sensors)
    run = simulate(drive, lambda index: (wanted[index, 0], wanted[index, 1]), SECONDS)
    return simulation_recording(run, drive)


@pytest.fixture(scope="module")
def stuck() -> Recording:
    return _with_rests(FRICTION)


def test_the_true_friction_fits_only_with_noise_in_the_loop(stuck: Recording) -> None:
    """The true parameters leave over twice the noise in a silent replay, and noise in a shaken."""
    replay = Replay(stuck, DRIVE, "stuck")
    fitter = Fitter(replay, held_out(replay.time_s))
    silent = misfit(fitter.evaluate(FRICTION).judged)
    assert silent > 2.0 * fitter.perfect
    assert fitter.perfect_with(FRICTION) > 1.5 * fitter.perfect  # noise alone would account for it
    replay.shake()
    assert misfit(fitter.evaluate(FRICTION).judged) < 1.3 * fitter.perfect


def test_a_tenth_of_the_noise_in_the_loop_makes_friction_creep() -> None:
    """A tenth of the sensors' noise goes round, the rest is the logger's: a silent replay of the
    true friction leaves more than a perfect model, one shaken by that tenth does not; of the drive
    without friction a perfect model leaves the recorded noise."""
    quiet = _with_rests(FRICTION, noise=0.1)
    rng = np.random.default_rng(5)
    rest = np.sqrt(1.0 - 0.1**2)
    logged = {
        "rotor_position_rad": DRIVE.sensors.rotor_position_noise,
        "rotor_velocity_rad_per_s": DRIVE.sensors.rotor_velocity_noise,
        "current_q_a": DRIVE.sensors.current_noise,
        "rod_position_m": DRIVE.sensors.rod_position_noise,
    }
    noisy = {
        name: getattr(quiet, name) + rest * std * rng.standard_normal(len(quiet))
        for name, std in logged.items()
    }
    replay = Replay(dataclasses.replace(quiet, **noisy), DRIVE, "a tenth")
    fitter = Fitter(replay, held_out(replay.time_s))
    assert replay.loop_share == pytest.approx(0.1, rel=0.3)
    at = [one.name != "voltage_q" for one in replay.signals]
    np.testing.assert_allclose(np.std(replay.healthy[at], axis=1), 1.0, atol=0.1)
    silent = misfit(fitter.evaluate(FRICTION).judged)
    replay.shake()
    shaken = misfit(fitter.evaluate(FRICTION).judged)
    assert silent > 1.3 * fitter.perfect > shaken


def test_noise_in_the_loop_leaves_the_nominal_replay_as_it_was(stuck: Recording) -> None:
    """What the noise does to the drive without effects is subtracted again."""
    replay = Replay(stuck, DRIVE, "stuck")
    before = replay.gap({})
    replay.shake()
    np.testing.assert_allclose(replay.gap({}), before, atol=1e-6)


def test_a_loop_without_noise_is_not_shaken() -> None:
    """A recording whose command shows no sensor noise: a perfect model leaves white noise."""
    quiet = dataclasses.replace(
        DRIVE,
        sensors=dataclasses.replace(
            DRIVE.sensors, rotor_velocity_noise=0.0, rotor_position_noise=0.0, current_noise=0.0
        ),
        effects=FRICTION,
    )
    run = simulate(
        quiet, lambda index: (1e-3 * np.sin(0.006 * index), 0.006 * np.cos(0.006 * index)), 6.0
    )
    replay = Replay(simulation_recording(run, quiet), DRIVE, "quiet")
    assert not replay.noise_in_loop
    fitter = Fitter(replay, held_out(replay.time_s))
    assert fitter.perfect_with(FRICTION) == fitter.perfect


@pytest.mark.slow
def test_friction_that_noise_shakes_loose_is_named(stuck: Recording) -> None:
    """Moves and rests with Coulomb friction: of all that resists the motion it alone is named, its
    level within 2 %."""
    resists = [name for name in CATALOGUE if "friction" in name and "drift" not in name]
    result = diagnose(stuck, DRIVE, without=without_all_but(*resists, "backlash_error"))
    assert [one.effect for one in result.causes] == ["rotor_coulomb_friction"]
    assert result.verdict == "explained" and result.shrink > 0.9
    assert result.causes[0].parameters[0].value == pytest.approx(0.1, rel=0.02)


def test_a_fit_far_below_the_floor_says_that_no_noise_is_in_the_loop() -> None:
    """Without a recorded command all noise counts as in the loop, until the model fits better."""
    silent_run = _with_rests({}, noise=0.0)
    rng = np.random.default_rng(2)
    # So much noise of the speed would move rotor and rod by many times their own noise.
    loud = 30.0 * DRIVE.sensors.rotor_velocity_noise
    sensors = dataclasses.replace(DRIVE.sensors, rotor_velocity_noise=loud)
    drive = dataclasses.replace(DRIVE, sensors=sensors)
    noisy = {
        "rotor_position_rad": sensors.rotor_position_noise,
        "rotor_velocity_rad_per_s": sensors.rotor_velocity_noise,
        "current_q_a": sensors.current_noise,
    }
    columns = {
        name: getattr(silent_run, name) + std * rng.standard_normal(len(silent_run))
        for name, std in noisy.items()
    }
    gone = np.full(len(silent_run), np.nan)
    recording = dataclasses.replace(silent_run, **columns, voltage_q_v=gone)
    replay = Replay(recording, drive, "quiet")
    fitter = Fitter(replay, held_out(replay.time_s))
    assert replay.noise_in_loop and fitter.perfect > 1.4
    # A model that stands there may stand far above the true floor: the search goes on.
    assert fitter.floor_unsure and not surely_at_noise(fitter, fitter.nominal)
    assert at_noise(fitter, fitter.nominal)
    fitter.test_floor(fitter.nominal)
    assert not replay.noise_in_loop and fitter.perfect < 1.0
    assert surely_at_noise(fitter, fitter.nominal)
