"""Several recordings of one full cylinder, emulated with faults of known size."""

from __future__ import annotations

import dataclasses
import json

import numpy as np
import pytest
from short_motions import DRIVE, recorded
from small_field import without_all_but

import ecyl_ros as ec
from ecyl_ros.drive.parameters import DriveParameters
from ecyl_ros.errors import InputError
from ecyl_ros.gap.diagnosis import Diagnosis
from ecyl_ros.gap.replay.replay import Replay
from ecyl_ros.gap.report.page import report_html
from ecyl_ros.gap.report.terminal import summary
from ecyl_ros.gap.several.joined_replay import JoinedReplay
from ecyl_ros.gap.several.together import diagnose_together
from ecyl_ros.recording.signals import Recording

FRICTION = "rotor_coulomb_friction"
WITHOUT = without_all_but(
    FRICTION, "load_coulomb_friction", "constant_load", "rotor_viscous_friction"
)
NAMES = ["a.mcap", "b.mcap", "c.mcap"]


def together(
    recordings: list[Recording], drive: DriveParameters = DRIVE, without: list[str] = WITHOUT
) -> Diagnosis:
    """Their diagnosis, in a small field."""
    return diagnose_together(recordings, drive, without=without, sources=NAMES[: len(recordings)])


@pytest.fixture(scope="module")
def friction() -> Diagnosis:
    """Of 0.11 N m on the rotor in all three, with a torque constant 1 % off."""
    return together([recorded(n, {FRICTION: {"coulomb_nm": 0.11}}, 1.01) for n in range(3)])


def test_one_cause_with_one_value_is_named_for_all(friction) -> None:
    """The true torque lies within the interval, and the torque constant is found in the sheet."""
    (cause,) = friction.causes
    (level,) = cause.parameters
    assert friction.verdict == "explained" and cause.effect == FRICTION
    assert level.low <= 0.11 <= level.high
    constant = next(one for one in friction.sheet if one.parameter == "motor.torque_constant")
    assert constant.low <= 1.01 * DRIVE.motor.torque_constant <= constant.high


def test_each_recording_is_told_by_itself_and_by_the_others(friction) -> None:
    """Every one shows the true torque by itself, and loses its gap by what the others give; the
    last is explained by what the others alone name."""
    assert [one.source for one in friction.recordings] == NAMES
    for one in friction.recordings:
        level = next(v for v in one.values if v.of == FRICTION)
        assert level.low <= 0.11 <= level.high and not level.differs
        assert one.shrink > 0.95 and one.unseen is not None and one.unseen > 0.95
    unseen = friction.unseen
    assert unseen is not None and unseen.source == "c.mcap"
    assert unseen.causes == (FRICTION,) and unseen.shrink > 0.95


def test_report_json_and_summary_tell_of_each(friction) -> None:
    """A section each on the page, a row each in the summary, an entry each in the JSON."""
    page, text = report_html(friction), " ".join(summary(friction).split())
    assert all(f"<h3>{name}</h3>" in page for name in NAMES)
    assert "Named on a.mcap and b.mcap alone, it removes" in text
    data = json.loads(json.dumps(friction.as_json()))
    assert data["schema"] == "ecyl.diagnosis/1"
    assert [one["recording"] for one in data["recordings"]] == NAMES
    assert data["unseen"]["shrink"] > 0.95


def test_a_friction_that_rose_is_said_with_both_values() -> None:
    """0.11 N m in one recording and 0.14 in the next: both are told, the twin has the last, and
    what is left is noise."""
    levels = (0.11, 0.14)
    found = together([recorded(n, {FRICTION: {"coulomb_nm": levels[n]}}) for n in range(2)])
    (cause,) = found.causes
    assert found.verdict == "explained" and cause.effect == FRICTION
    values = [next(v for v in one.values if v.of == FRICTION) for one in found.recordings]
    assert [one.value for one in values] == pytest.approx(levels, rel=0.02)
    assert all(one.differs for one in values)
    assert found.values[FRICTION]["coulomb_nm"] == pytest.approx(0.14, rel=0.02)
    assert "Not the same in all" in " ".join(summary(found).split())


def test_recordings_are_replayed_each_from_its_own_start() -> None:
    """What a joined replay leaves of a recording is what its own replay leaves, sample by sample,
    but for the edges where filters reach from one into the next."""
    parts = [
        Replay(recorded(n, {FRICTION: {"coulomb_nm": 0.11}}), DRIVE, name)
        for n, name in enumerate(NAMES)
    ]
    joined = JoinedReplay(parts)
    effects = {"load_coulomb_friction": {"coulomb_nm": 0.05, "breakaway_rad": 1e-3}}
    effects = joined.complete(effects, {})
    constants = {"motor.torque_constant": 0.98 * DRIVE.motor.torque_constant}
    gap = joined.gap(effects, constants)
    for one, span in zip(parts, joined.spans, strict=True):
        inner = joined.usable[span]
        assert inner.sum() > 0.9 * len(inner)
        alone = one.gap(effects, constants)
        assert np.array_equal(gap[:, span][:, inner], alone[:, inner])
    held = [one.held_out() for one in parts]
    assert np.array_equal(joined.held_out(), np.concatenate(held))


def test_what_swings_with_time_has_a_phase_of_each_recording() -> None:
    """Phases that were not given are found in each of the others, to be fitted beside the rest."""
    phases = (0.3, 2.5, -1.4)
    size = {"amplitude_n": 60.0, "frequency_hz": 7.0}
    runs = [
        recorded(n, {"periodic_disturbance": {**size, "phase_rad": phases[n]}}) for n in range(3)
    ]
    joined = JoinedReplay([Replay(one, DRIVE, name) for one, name in zip(runs, NAMES, strict=True)])
    found = joined.complete({"periodic_disturbance": {**size, "phase_rad": phases[0]}}, {})
    values = found["periodic_disturbance"]
    for number in (1, 2):
        off = values[f"phase_rad@{number}"] - phases[number]
        assert abs(np.angle(np.exp(1j * off))) < 0.05
    assert (
        joined.effects_in(2, found)["periodic_disturbance"]["phase_rad"] == (values["phase_rad@2"])
    )


def test_a_recording_at_a_lower_rate_goes_beside_the_others() -> None:
    """One has a quarter of the other's samples: both are compared at its rate, and one friction is
    named."""
    effects = {FRICTION: {"coulomb_nm": 0.11}}
    fast, slow = recorded(0, effects), recorded(1, effects)
    every = {one.name: getattr(slow, one.name) for one in dataclasses.fields(slow)}
    slow = dataclasses.replace(
        slow, **{name: one[::4] for name, one in every.items() if isinstance(one, np.ndarray)}
    )
    found = together([fast, slow])
    assert [one.effect for one in found.causes] == [FRICTION]
    assert found.rate_hz == pytest.approx(DRIVE.sample_rate / 4.0, rel=0.01)


def test_what_cannot_be_diagnosed_together_is_refused() -> None:
    """One clear line each: two machines, a signal that one lacks, a mode."""
    effects = {FRICTION: {"coulomb_nm": 0.11}}
    runs = [recorded(0, effects), recorded(1, effects, 1.2)]
    with pytest.raises(InputError, match=r"^a\.mcap and b\.mcap: .* expected recordings of one"):
        together(runs, without=without_all_but(FRICTION))
    bare = dataclasses.replace(runs[1], current_q_a=np.full(len(runs[1]), np.nan))
    with pytest.raises(InputError, match=r"^b\.mcap: current_q in A is missing, which a\.mcap has"):
        together([runs[0], bare])
    with pytest.raises(InputError, match="judged in all modes"):
        ec.diagnose(runs, DRIVE, mode=1.0)
