"""What a replay says of causes that the balance of efforts has named."""

from __future__ import annotations

import pytest
from rigid_machines import ROTARY, motion, recorded

from ecyl_ros.gap.diagnose import diagnose
from ecyl_ros.gap.diagnosis import SignalGap
from ecyl_ros.gap.rigid import assemble
from ecyl_ros.gap.rigid.replay import Replay


@pytest.fixture
def heavy():
    """A machine of half the stated inertia, and nothing else."""
    m = motion(1.0)
    return recorded(m, 0.5 * (ROTARY.inertia or 0.0) * m.a, ROTARY, 1e-4, 1e-5)


def test_a_cause_that_its_replay_bears_out_is_named(heavy) -> None:
    """Half the stated inertia: position and speed come nearer with it, and it is named."""
    result = diagnose(heavy, ROTARY)
    assert [one.effect for one in result.causes] == ["rotor_inertia_error"]
    assert result.verdict == "explained"
    assert all(one.after < 0.1 * one.gap for one in result.signals)


@pytest.mark.parametrize(
    ("position", "speed", "verdict", "named"),
    [
        ((9.0, 9.1), (5.0, 5.0), "unexplained", False),  # neither comes nearer
        ((9.0, 9.1), (5.0, 2.0), "partly_explained", True),  # one goes further off
        ((9.0, 1.2), (0.9, 1.2), "explained", True),  # within the floor it may
        ((1.2, 1.25), (0.9, 0.95), "explained", True),  # nothing was off
    ],
)
def test_a_replay_that_gets_worse_lowers_the_verdict(
    heavy, monkeypatch, position, speed, verdict, named
) -> None:
    """Floors of a replay without and with the cause: no signal nearer, it is none; one further
    off, the gap is not explained as a whole; either is noted."""
    signals = tuple(
        SignalGap(name, unit, gap, after, 1.0)
        for name, unit, (gap, after) in (("position", "rad", position), ("speed", "rad/s", speed))
    )
    monkeypatch.setattr(assemble, "replay", lambda judgement, ruling: Replay(signals=signals))
    result = diagnose(heavy, ROTARY)
    noted = any(note.startswith(("closest in", "replayed with")) for note in result.notes)
    assert result.verdict in ((verdict, "described") if not named else (verdict,))
    assert bool(result.causes) == named
    assert noted == (verdict != "explained")
