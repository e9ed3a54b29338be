"""What the motion says of causes that the balance of efforts has named."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from rigid_machines import ROTARY, motion, recorded

from ecyl_ros.gap.diagnose import diagnose
from ecyl_ros.gap.diagnosis import SignalGap
from ecyl_ros.gap.rigid import assemble
from ecyl_ros.gap.rigid.judge import Judgement
from ecyl_ros.gap.rigid.replay import Replay
from ecyl_ros.gap.rigid.ruling import Ruling


def _light(share: float):
    """A machine of a share of the stated inertia, and nothing else."""
    m = motion(1.0)
    return recorded(m, share * (ROTARY.inertia or 0.0) * m.a, ROTARY, 1e-4, 1e-5)


@pytest.mark.parametrize("share", [0.5, 0.1])
def test_a_lighter_output_that_moves_as_recorded_is_named(share) -> None:
    """A half and a tenth of the stated inertia: position and speed come nearer, and it is named."""
    result = diagnose(_light(share), ROTARY)
    assert [one.effect for one in result.causes] == ["rotor_inertia_error"]
    assert result.verdict == "explained"
    assert all(one.after < 0.1 * one.gap for one in result.signals)


def test_white_noise_is_no_acceleration_that_a_lighter_output_leaves() -> None:
    """Seven tenths of the inertia under much noise: over the inertia the noise is more than all was
    before, and the inertia is named, its true value within the interval."""
    sheet = dataclasses.replace(ROTARY, tolerances={"load.inertia": 0.05})
    true = 0.7 * (ROTARY.inertia or 0.0)
    m = motion(1.0)
    noise = 0.8 * true * float(np.std(m.a))
    result = diagnose(recorded(m, true * m.a, sheet, noise, 1e-5), sheet)
    (cause,) = result.causes
    (inertia,) = cause.parameters
    assert cause.effect == "rotor_inertia_error"
    assert inertia.low <= true <= inertia.high
    (gap,) = (one for one in result.signals if one.judged)
    assert gap.after > 0.7 * gap.gap  # else this is no test of it


def test_a_lighter_output_that_leaves_as_much_acceleration_is_none(monkeypatch) -> None:
    """A tenth of the inertia with which an eighth of the effort is left: over the inertia that is
    more than before, so nothing is named, and a note says what came closest."""
    rule = Judgement.rule

    def swung(self: Judgement) -> Ruling:
        ruling = rule(self)
        return dataclasses.replace(ruling, after=ruling.before / 8.0)

    monkeypatch.setattr(Judgement, "rule", swung)
    result = diagnose(_light(0.1), ROTARY)
    assert result.verdict in ("unexplained", "described") and not result.causes
    said = "leaves no less acceleration unexplained"
    assert any(said in note for note in result.notes)


@pytest.mark.parametrize(
    ("position", "speed", "verdict"),
    [
        ((9.0, 9.1), (5.0, 2.0), "partly_explained"),  # one goes further off
        ((9.0, 1.2), (0.9, 1.2), "explained"),  # within the floor it may
        ((1.2, 1.25), (0.9, 0.95), "explained"),  # nothing was off
    ],
)
def test_a_replay_that_gets_worse_lowers_the_verdict(monkeypatch, position, speed, verdict) -> None:
    """Floors of a replay without and with the cause: with one signal further off, the gap is not
    explained as a whole, and that is noted."""
    signals = tuple(
        SignalGap(name, unit, gap, after, 1.0)
        for name, unit, (gap, after) in (("position", "rad", position), ("speed", "rad/s", speed))
    )
    monkeypatch.setattr(assemble, "replay", lambda judgement, ruling: Replay(signals=signals))
    result = diagnose(_light(0.5), ROTARY)
    noted = any(note.startswith("in the replay with") for note in result.notes)
    assert result.verdict == verdict and result.causes
    assert noted == (verdict != "explained")


def test_a_replay_that_goes_twice_as_far_off_refutes_its_cause(monkeypatch) -> None:
    """Position 3 floors off without the cause and 7 with it: no cause, and a note says which."""
    signals = (SignalGap("position", "rad", 3.0, 7.0, 1.0),)
    monkeypatch.setattr(assemble, "replay", lambda judgement, ruling: Replay(signals=signals))
    result = diagnose(_light(0.5), ROTARY)
    assert result.verdict in ("unexplained", "described") and not result.causes
    assert any("times as far off as without: wrong rotor" in note for note in result.notes)


def test_a_replay_that_runs_away_without_causes_refutes_none(monkeypatch) -> None:
    """Friction that the file leaves out: the replay goes further off than the recording moves,
    without its cause and with it, which says nothing of the cause."""
    m = motion(1.0)
    effort = 0.02 * m.a + 0.2 * np.sign(m.v)
    recording = recorded(m, effort, ROTARY, 1e-3, 1e-5)

    def away(judgement: Judgement, ruling: Ruling) -> Replay:
        at = judgement.motion.position[judgement.motion.rows]
        signals = (SignalGap("position", "rad", 30.0, 90.0, 1.0),)
        return Replay(signals, at[None], at[None] + 50.0, at[None] + 150.0)

    monkeypatch.setattr(assemble, "replay", away)
    result = diagnose(recording, ROTARY)
    assert [one.effect for one in result.causes] == ["rotor_coulomb_friction"]
    assert any("runs away" in note for note in result.notes)
