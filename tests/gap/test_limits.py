"""How small a fault a recording would have shown, against recordings that hold one."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from rigid_machines import LINEAR, motion, recorded
from sheets import exact

from ecyl_ros.drive.engine import simulate
from ecyl_ros.drive.parameters import DriveParameters
from ecyl_ros.drive.reference.moves import Moves
from ecyl_ros.drive.telemetry import simulation_recording
from ecyl_ros.gap.diagnose import diagnose
from ecyl_ros.gap.fit.fit import Fitter
from ecyl_ros.gap.fit.robust import robust_squares
from ecyl_ros.gap.judge.verdict import at_floor
from ecyl_ros.gap.limits.cylinder import seen_by
from ecyl_ros.gap.limits.limit import Limit
from ecyl_ros.gap.limits.loss import rise
from ecyl_ros.gap.limits.possible import possible
from ecyl_ros.gap.limits.rigid import rigid_limits
from ecyl_ros.gap.limits.seen import Seen
from ecyl_ros.gap.replay.replay import Replay
from ecyl_ros.gap.rigid.diagnose import judged
from ecyl_ros.gap.rigid.motion import motion_of
from ecyl_ros.gap.split import held_out
from ecyl_ros.recording.signals import Recording

MOVES = Moves((0.004, -0.002, 0.001), speed=0.05, acceleration=1.0, jerk=50.0)


def _recorded(drive: DriveParameters) -> Recording:
    rate = drive.sample_rate
    run = simulate(drive, lambda index: MOVES.sample(index / rate), 2.0)
    return simulation_recording(run, drive)


def _fitter(recording: Recording, drive: DriveParameters) -> Fitter:
    replay = Replay(recording, drive, "test")
    return Fitter(replay, held_out(replay.time_s))


@pytest.fixture(scope="module")
def sound() -> tuple[DriveParameters, Fitter]:
    """A healthy drive of exact constants, recorded."""
    drive = exact("bench")
    return drive, _fitter(_recorded(drive), drive)


def _smallest(fitter: Fitter, name: str) -> Seen:
    _, found = seen_by(fitter, fitter.nominal, [name])
    return found[0]


@pytest.mark.parametrize("name", ["rotor_coulomb_friction", "constant_load", "backlash_error"])
def test_a_fault_is_seen_from_the_stated_size_on(sound, name: str) -> None:
    """Half as large again it is off the floor; a tenth as large the recording shows no gap."""
    drive, fitter = sound
    smallest = _smallest(fitter, name)
    for times, seen in ((1.5, True), (0.1, False)):
        values = smallest.probe.made(times * smallest.size)
        faulty = dataclasses.replace(drive, effects={name: values})
        other = _fitter(_recorded(faulty), drive)
        assert at_floor(other.nominal, other.replay) is not seen, times


def test_an_uncertain_sheet_hides_more(sound) -> None:
    """With constants known to 10 % the smallest visible wrong inertia is that of the sheet."""
    _, fitter = sound
    loose = dataclasses.replace(exact("bench"), tolerances={"all": 0.1})
    hidden = _smallest(_fitter(_recorded(loose), loose), "load_inertia_error")
    tight = _smallest(fitter, "load_inertia_error")
    assert hidden.size > 3.0 * tight.size
    assert hidden.size > 0.1 * loose.load.inertia


def test_the_rise_is_that_of_drawn_noise() -> None:
    """By how much a difference raises Cauchy's mean square, against a million draws."""
    noise = np.random.default_rng(3).standard_normal(1_000_000)
    for difference in (0.3, 1.0, 4.0):
        drawn = np.mean(robust_squares(noise + difference) - robust_squares(noise))
        assert rise(np.array([difference]))[0] == pytest.approx(drawn, rel=0.02)


def test_a_rigid_drive_shows_friction_of_the_stated_size() -> None:
    """Friction twice the stated size is no healthy machine; a fifth of it is."""
    way = motion(0.05)

    def diagnosed(friction: float):
        effort = LINEAR.inertia * way.a + friction * np.tanh(way.v / 1e-4)
        return diagnose(recorded(way, effort, LINEAR, 0.2, 1e-7), LINEAR)

    none = diagnosed(0.0)
    smallest = {one.effect: one.smallest_seen for one in none.limits}["load_coulomb_friction"]
    assert none.verdict in ("no_gap", "within_sheet")
    assert diagnosed(2.0 * smallest).verdict not in ("no_gap", "within_sheet")
    assert diagnosed(0.2 * smallest).verdict in ("no_gap", "within_sheet")


def test_limits_are_part_of_the_diagnosis(sound) -> None:
    """The JSON of a healthy drive states a size for every effect of one; all are positive."""
    drive, fitter = sound
    said = diagnose(fitter.replay.recording, drive).as_json()
    sizes = {one["effect"]: one["smallest_seen"] for one in said["limits"]}
    assert said["verdict"] == "no_gap"
    assert {"rotor_coulomb_friction", "cogging_torque", "voltage_limit"} <= set(sizes)
    assert all(size is None or size > 0.0 for size in sizes.values())


@pytest.mark.parametrize(
    ("effect", "parameter", "size", "neutral", "kept"),
    [
        ("torque_ripple", "fraction", 0.2, 0.0, True),
        ("torque_ripple", "fraction", 12.2, 0.0, False),
        ("actuation_delay", "delay_s", 0.02, 0.0, True),
        ("actuation_delay", "delay_s", 4.08, 0.0, False),
        ("torque_constant_error", "torque_constant_nm_per_a", 0.05, 0.5, True),
        ("torque_constant_error", "torque_constant_nm_per_a", 0.41, 0.5, False),
        ("constant_load", "force_n", 50.0, 0.0, True),
    ],
)
def test_no_limit_is_beyond_what_can_be(
    effect: str, parameter: str, size: float, neutral: float, kept: bool
) -> None:
    """A ripple of more than all torque, a delay of seconds, another motor: not at any size."""
    found = possible(Limit(effect, parameter, "1", size, neutral)).smallest_seen
    assert found == (size if kept else None)


@pytest.mark.parametrize("friction", [0.0, 1.5])
def test_a_limit_is_not_below_what_is_there_unnamed(friction: float) -> None:
    """Friction that the recording shows, left unnamed, has no limit that says that it would have
    been shown; without friction it has one."""
    way = motion(0.05)
    effort = LINEAR.inertia * way.a + friction * np.tanh(way.v / 1e-4)
    moved = motion_of(recorded(way, effort, LINEAR, 0.2, 1e-7), LINEAR, "x")
    judgement = judged(moved, LINEAR, (), "x", lambda share: None)
    judgement.contest = dataclasses.replace(judgement.contest, order=())
    sizes = {one.effect: one.smallest_seen for one in rigid_limits(judgement)}
    assert (sizes.get("load_coulomb_friction") is None) is (friction > 0.0)
