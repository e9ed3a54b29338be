"""Several recordings of one rigid machine whose effort is known in closed form."""

from __future__ import annotations

import dataclasses
import json

import numpy as np
import pytest
from rigid_machines import LINEAR, Motion, motion, recorded

import ecyl_ros as ec
from ecyl_ros.drive.rigid.machine import Machine
from ecyl_ros.errors import InputError
from ecyl_ros.gap.diagnose import diagnose
from ecyl_ros.gap.diagnosis import Diagnosis
from ecyl_ros.gap.report.page import report_html
from ecyl_ros.gap.report.terminal import summary
from ecyl_ros.gap.rigid.joined import joined, motions_of
from ecyl_ros.gap.rigid.motion import motion_of
from ecyl_ros.gap.rigid.rest import at_rest
from ecyl_ros.gap.several.together import diagnose_together
from ecyl_ros.recording.signals import Recording

MOTIONS = [motion(0.1, seed, 6.0) for seed in (3, 4, 5)]
RUBS = dataclasses.replace(LINEAR, coulomb=4.0, tolerances={"load.mass": 0.05})
NAMES = ["a.mcap", "b.mcap", "c.mcap"]


def _runs(asked, machine: Machine = LINEAR, noise=(0.3, 0.3, 0.3)) -> list[Recording]:
    """Recordings of the motions; asked: effort beyond M a, from a motion and its number."""
    return [
        recorded(m, 20.0 * m.a + asked(m, number), machine, noise[number], 1e-6, seed=number)
        for number, m in enumerate(MOTIONS)
    ]


def _together(recordings: list[Recording], machine: Machine = LINEAR) -> Diagnosis:
    return diagnose_together(recordings, machine, sources=NAMES[: len(recordings)])


def _rubs(level: float):
    return lambda m, number: level * np.sign(m.v)


@pytest.fixture(scope="module")
def friction() -> Diagnosis:
    """Of a Coulomb friction of 9 N in all three."""
    return _together(_runs(_rubs(9.0)))


def test_one_set_of_causes_is_named_for_all_with_one_value(friction) -> None:
    """The friction that acts in all three is named once, its true level within the interval."""
    (cause,) = friction.causes
    (level,) = cause.parameters
    assert friction.verdict == "explained" and cause.effect == "load_coulomb_friction"
    assert level.low <= 9.0 <= level.high


def test_the_last_recording_is_explained_by_what_the_others_name(friction) -> None:
    """Named on a and b alone, it removes nearly all of the gap on c, which had no part in it: the
    same is named whatever c holds, and where something else acts there, little is removed."""
    unseen = friction.unseen
    assert unseen is not None and unseen.source == "c.mcap"
    assert unseen.named_on == ("a.mcap", "b.mcap")
    assert unseen.causes == ("load_coulomb_friction",) and unseen.shrink > 0.95
    other = _runs(lambda m, number: (9.0 if number < 2 else -2.0) * np.sign(m.v) + 300.0 * m.q)
    found = _together(_runs(_rubs(9.0))[:2] + other[2:]).unseen
    assert found is not None and found.causes == unseen.causes and found.shrink < 0.5


def test_what_is_said_of_each_recording_is_its_own(friction) -> None:
    """Gap, floor and value of each are those of that recording alone."""
    assert [one.source for one in friction.recordings] == NAMES
    for one in friction.recordings:
        level = next(v for v in one.values if v.of == "load_coulomb_friction")
        assert level.low <= 9.0 <= level.high and not level.differs
        assert one.before == pytest.approx(9.0, rel=0.1) and one.shrink > 0.95
        assert one.unseen is not None and one.unseen > 0.95


def test_a_noisy_recording_counts_less_and_has_a_floor_of_its_own() -> None:
    """Of three recordings one has ten times the noise: its floor is far higher than the others',
    and it leaves the value as sure as they have it."""
    found = _together(_runs(_rubs(9.0), noise=(0.3, 0.3, 3.0)))
    quiet, _, loud = (one.floor for one in found.recordings)
    assert loud > 2.0 * quiet
    (level,) = found.causes[0].parameters
    assert level.low <= 9.0 <= level.high and level.high - level.low < 0.7


def test_what_is_slow_beside_another_recording_is_no_rest() -> None:
    """One at a hundredth of the other's speed rests where it does by itself, and no longer; both
    can be diagnosed together."""
    runs = [
        recorded(m, 20.0 * m.a + 9.0 * np.sign(m.v), LINEAR, 0.3, 1e-10, seed=number)
        for number, m in enumerate((motion(1e-3, 3, 6.0), motion(0.1, 4, 6.0)))
    ]
    motions = motions_of(runs, LINEAR, NAMES[:2], None)
    both = joined(motions, NAMES[:2])
    rests = at_rest(both)
    for part, one in zip(both.parts, motions, strict=True):
        assert np.mean(rests[part] != at_rest(one)) < 0.01  # at the seam
        assert np.mean(rests[part]) < 0.1
    (cause,) = _together(runs).causes
    (level, *_) = cause.parameters
    assert level.name == "coulomb_n" and level.value == pytest.approx(9.0, rel=0.02)


def test_a_value_that_differs_is_said_with_both_and_not_averaged() -> None:
    """Friction of 9 N in two recordings and 14 N in the third: both are said, the twin takes the
    last, and the fit is as close as if they were the same."""
    found = _together(_runs(lambda m, number: (9.0, 9.0, 14.0)[number] * np.sign(m.v)))
    (cause,) = found.causes
    assert cause.effect == "load_coulomb_friction" and found.verdict == "explained"
    assert cause.parameters[0].value == pytest.approx(14.0, rel=0.03)
    values = [one.values[0] for one in found.recordings]
    assert [one.value for one in values] == pytest.approx([9.0, 9.0, 14.0], rel=0.03)
    assert all(one.differs for one in values)
    text = " ".join(summary(found).split())
    assert "Not the same in all: Coulomb friction on the load, Coulomb force" in text
    assert "14.0" in text and "in c.mcap" in text


def test_a_disturbance_begins_in_a_phase_of_its_own_in_each() -> None:
    """A sine of 7 Hz that no clock ties to the recordings is one cause with one size."""
    phases = (0.3, 2.5, 4.4)
    found = _together(
        _runs(lambda m, number: 5.0 * np.sin(2.0 * np.pi * 7.0 * m.t + phases[number]))
    )
    (cause,) = found.causes
    values = {one.name: one.value for one in cause.parameters}
    assert cause.effect == "periodic_disturbance" and found.verdict == "explained"
    assert values["frequency_hz"] == pytest.approx(7.0, rel=1e-3)
    assert values["amplitude_n"] == pytest.approx(5.0, rel=0.03)
    assert found.unseen is not None and found.unseen.shrink > 0.9


def test_a_copy_is_no_second_recording() -> None:
    """The same samples under another name would be held out of what they were fitted to."""
    runs = _runs(lambda m, number: 9.0 * np.sign(m.v))
    later = dataclasses.replace(runs[0], stamp_ns=runs[0].stamp_ns + 5 * 10**9)
    with pytest.raises(InputError, match=r"^a\.mcap and c\.mcap hold the same samples"):
        _together([runs[0], runs[1], later])


def test_recordings_of_different_machines_are_refused() -> None:
    """20 and 26 kg cannot both be within one sheet of 5 %: one line says which recordings."""
    runs = _runs(_rubs(4.0), RUBS)
    m = MOTIONS[1]
    runs[1] = recorded(m, 26.0 * m.a + 4.0 * np.sign(m.v), RUBS, 0.3, 1e-6)
    with pytest.raises(
        InputError, match=r"^a\.mcap and b\.mcap: load\.mass is 2.* whose parts move as one$"
    ):
        _together(runs, RUBS)


def test_a_signal_that_one_lacks_and_another_kind_of_drive_are_refused() -> None:
    """One clear line for what cannot be diagnosed together."""
    runs = _runs(_rubs(9.0))
    bare = dataclasses.replace(runs[1], rod_force_n=np.full(len(runs[1]), np.nan))
    with pytest.raises(InputError, match=r"^b\.mcap: rod_force in N is missing, which a\.mcap has"):
        _together([runs[0], bare])
    follower = dataclasses.replace(LINEAR, kind="follower")
    with pytest.raises(InputError, match=r"^a\.mcap: expected two or more recordings"):
        _together(_runs(_rubs(9.0))[:1])
    with pytest.raises(InputError, match="follower is judged one recording at a time"):
        ec.diagnose(runs, follower)
    with pytest.raises(InputError, match="1 recordings in a list, expected two or more"):
        ec.diagnose(runs[:1], LINEAR)
    with pytest.raises(InputError, match=r"^x\.mcap: given twice; expected different recordings"):
        ec.diagnose(["x.mcap", "./x.mcap", "y.mcap"], LINEAR)
    with pytest.raises(InputError, match=r"long, expected at least 1\.5 s"):
        _together([runs[0], runs[1].slice(0.0, 1.0)])


def test_recordings_at_different_rates_go_together() -> None:
    """One is sampled at half the rate of the other: the same friction is named."""
    fast, slow = _runs(_rubs(9.0))[:2]
    slow = dataclasses.replace(
        slow,
        **{
            name: getattr(slow, name)[::2]
            for name in [one.name for one in dataclasses.fields(slow)]
            if isinstance(getattr(slow, name), np.ndarray)
        },
    )
    found = _together([fast, slow])
    assert [one.effect for one in found.causes] == ["load_coulomb_friction"]
    assert found.rate_hz == pytest.approx(500.0)


def test_a_single_recording_is_the_case_of_one() -> None:
    """A motion joined of one recording compares the same, sample by sample."""
    run = _runs(_rubs(9.0))[0]
    own = motion_of(run, LINEAR, "a")
    one = joined(motions_of([run], LINEAR, ["a"]), ["a"])
    assert one.bandwidth_hz == own.bandwidth_hz and np.array_equal(one.rows, own.rows)
    assert np.array_equal(one.filtered(own.effort), own.filtered(own.effort))
    late = np.array([0.0, 1.7e-3])
    assert np.array_equal(one.shifted(own.effort, late), own.shifted(own.effort, late))


def test_no_stretch_is_of_two_recordings(friction) -> None:
    """Held-out stretches begin and end within one recording, and every recording has some."""
    series = friction.series
    for one in friction.recordings:
        first, behind = one.rows
        assert (
            series.held_out[first:behind].any() and not series.held_out[[first, behind - 1]].any()
        )


def test_report_json_and_summary_tell_of_each(friction) -> None:
    """A section each on the page, a row each in the summary, an entry each in the JSON; a single
    recording's JSON has none."""
    page, text = report_html(friction), " ".join(summary(friction).split())
    assert all(f"<h3>{name}</h3>" in page for name in NAMES)
    assert "Named on a.mcap and b.mcap alone, it removes" in text
    assert "of the gap on c.mcap, which was held out" in text
    data = json.loads(json.dumps(friction.as_json()))
    assert data["schema"] == "ecyl.diagnosis/1"
    assert [one["recording"] for one in data["recordings"]] == NAMES
    assert data["unseen"]["named_on"] == NAMES[:2] and data["unseen"]["shrink"] > 0.95
    assert "recordings" not in diagnose(_runs(_rubs(9.0))[0], LINEAR).as_json()


def test_the_twin_of_several_is_judged_sound_on_another(tmp_path) -> None:
    """The drive file with the cause added leaves no gap on a recording that had no part in it."""
    drive = tmp_path / "axis.yaml"
    drive.write_text(
        "/**:\n  ros__parameters:\n    drive: {kind: rigid, output: linear}\n"
        "    actuation: {signal: force}\n    load: {mass: 20.0}\n"
    )
    runs = _runs(_rubs(9.0))
    ec.diagnose(runs[:2], drive).write_drive(tmp_path / "twin.yaml")
    assert diagnose(runs[2], ec.load_drive(tmp_path / "twin.yaml")).verdict == "no_gap"


def test_motion_of_a_part_is_filtered_by_itself() -> None:
    """What one recording is compared by does not depend on the others."""
    runs = _runs(_rubs(9.0))
    every: list[Motion] = motions_of(runs, LINEAR, NAMES)
    whole = joined(every, NAMES)
    compared = whole.filtered(whole.effort)
    for number, one in enumerate(every):
        assert np.array_equal(compared[whole.recording == number], one.filtered(one.effort))
