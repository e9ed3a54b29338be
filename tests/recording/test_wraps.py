"""Fields that start again: found, proposed and made whole; what merely looks so is left alone."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest

from ecyl_ros.cli.main import main
from ecyl_ros.errors import InputError
from ecyl_ros.recording.map import map_yaml
from ecyl_ros.recording.map_file import load_map, parse_map
from ecyl_ros.recording.mapped import read_mapped
from ecyl_ros.recording.propose import propose
from ecyl_ros.recording.survey import survey
from ecyl_ros.recording.wrap import find_clock_wrap, find_wrap, folded, parse_wrap, unwrapped

TIME = np.arange(5000) * 1e-3
ANGLE = 15.0 * np.sin(2.0 * np.pi * 0.4 * TIME) + 3.0 * TIME  # rad


def table(path: Path, **columns: np.ndarray) -> Path:
    rows = zip(*(np.asarray(values).tolist() for values in columns.values()), strict=True)
    text = "\n".join(",".join(repr(cell) for cell in row) for row in rows)
    path.write_text(f"{','.join(columns)}\n{text}\n")
    return path


@pytest.mark.parametrize(
    ("values", "said"),
    [
        (np.mod(np.round(ANGLE * 4096 / math.tau), 4096), "12bit"),
        (np.mod(np.round(ANGLE * 16384 / math.tau), 16384), "14bit"),
        (np.mod(np.round(ANGLE * 65536 / math.tau), 65536), "16bit"),
        (np.mod(np.round(ANGLE * 4e3) + 2**15, 2**16) - 2**15, "16bit"),
        (np.mod(np.round(ANGLE * 3e8) + 2**31, 2**32) - 2**31, "32bit"),
        (np.mod(ANGLE, math.tau), "rev"),
        (np.mod(ANGLE + math.pi, math.tau) - math.pi, "rev"),
        (np.mod(np.degrees(ANGLE), 360.0), "360"),
        (np.mod(np.round(10.0 * np.degrees(ANGLE)), 3600), "3600"),
        (np.mod(np.round(200.0 * np.sin(3.0 * TIME)), 65536), "signed 16bit"),
    ],
)
def test_what_starts_again_is_found_with_its_period(values: np.ndarray, said: str) -> None:
    """Encoders of 12 to 32 bits, angles of one turn and a lost sign are told by their ends."""
    found = find_wrap(values)
    assert found is not None and found.wrap.text == said
    if said != "signed 16bit":
        whole = unwrapped(values, math.tau if said == "rev" else found.wrap.period)
        assert np.abs(np.diff(whole)).max() < 0.05 * (found.high - found.low)


@pytest.mark.parametrize("period", [25.0, 8.0 * math.pi, 191.0])
def test_the_range_of_an_actuator_on_can_is_one(tmp_path: Path, period: float) -> None:
    """Positions in rad that go on at the other end of +-12.5, +-4 pi or +-95.5: a map has it."""
    angle = 1.6 * period * np.sin(2.0 * np.pi * 0.4 * TIME)
    sent = folded(angle, period)
    found = find_wrap(sent, "rad")
    assert found is not None and found.wrap.period == period
    np.testing.assert_allclose(unwrapped(sent, period), angle, atol=1e-9)
    assert find_wrap(0.4 * period * np.sin(2.0 * np.pi * 0.4 * TIME), "rad") is None
    path = table(tmp_path / "a.csv", t_s=TIME, pos_rad=sent)
    proposed = propose(survey(path)).map
    assert proposed is not None and f"wrap: {found.wrap.in_map}" in map_yaml(proposed)


@pytest.mark.parametrize(
    "values",
    [
        np.degrees(ANGLE),
        np.round(ANGLE * 4096 / math.tau),
        np.where(np.mod(TIME, 1.0) < 0.5, 0.0, 4095.0),
        np.where(np.mod(TIME, 1.0) < 0.5, -math.pi, math.pi),
        np.where(np.mod(TIME, 1.0) < 0.5, -0.5, 0.5) + 1e-3 * np.sin(50.0 * TIME),
        np.random.default_rng(1).uniform(0.0, math.tau, 5000),
        np.random.default_rng(1).integers(0, 4096, 5000).astype(float),
        5.0 * np.mod(TIME, 1.0),
        np.where(TIME < 2.5, 10.0, 350.0) + np.sin(TIME),
        np.zeros(5000),
    ],
)
def test_what_leaps_but_does_not_start_again_is_left_alone(values: np.ndarray) -> None:
    """Square waves, saw teeth of other heights, noise over a turn and one step are no wraps."""
    assert find_wrap(values) is None


def test_making_whole_undoes_the_wrap_exactly() -> None:
    """Unwrapped counts are those before they wrapped, across missing samples too."""
    counts = np.round(ANGLE * 4096 / math.tau)
    wrapped = np.mod(counts, 4096)
    wrapped[100:110] = np.nan
    whole = unwrapped(wrapped, 4096.0)
    known = np.isfinite(wrapped)
    np.testing.assert_array_equal(whole[known], counts[known])
    assert np.isnan(whole[100:110]).all()
    np.testing.assert_array_equal(
        folded(np.array([0.0, 65535.0, 32768.0]), 65536.0), [0, -1, -32768]
    )


@pytest.mark.parametrize(
    ("values", "said"),
    [
        (np.mod(np.arange(90_000) + 60_000, 65_536), "16bit"),
        (np.mod(np.arange(3_000) * 1_000 + 2**32 - 9_000, 2**32), "32bit"),
        (np.mod(np.arange(5_000) * 0.01, 1.0) * 1000.0, "1000"),
        (np.arange(5_000.0), None),
        (np.concatenate([np.arange(3_000.0), np.arange(2_000.0)]), None),
        (np.arange(5_000.0) + np.where(np.arange(5_000) % 100 == 0, -3.0, 0.0), None),
    ],
)
def test_a_clock_that_starts_again_is_told_from_one_that_was_set(
    values: np.ndarray, said: str | None
) -> None:
    """Counters of ms and us wrap at their bits; a clock set back and disorder are no wraps."""
    found = find_clock_wrap(np.asarray(values, dtype=float))
    assert (None if found is None else found.wrap.text) == said


def test_the_proposed_map_makes_an_encoder_whole(tmp_path: Path) -> None:
    """Of a 12 bit encoder and a 16 bit clock in ms the proposal gives rad over seconds."""
    counts = np.mod(np.round(ANGLE * 4096 / math.tau), 4096).astype(int)
    clock = np.mod(np.arange(5000) + 64_000, 65_536)
    path = table(tmp_path / "a.csv", time_ms=clock, encoder_counts=counts, target_rad=ANGLE)
    proposal = propose(survey(path))
    assert proposal.map is not None and proposal.map.time is not None
    rotor = proposal.map.of("rotor_position_rad")
    assert rotor is not None and rotor.wrap is not None
    assert (rotor.unit, rotor.counts_per_rev, rotor.wrap.text) == ("counts", 4096, "12bit")
    (tmp_path / "m.yaml").write_text(map_yaml(proposal.map))
    assert load_map(tmp_path / "m.yaml").signals == proposal.map.signals
    recording = read_mapped(path, load_map(tmp_path / "m.yaml"))
    assert recording.duration_s == pytest.approx(4.999)
    np.testing.assert_allclose(recording.rotor_position_rad, ANGLE, atol=math.tau / 4096)
    assert recording.resolution == {"rotor_position_rad": math.tau / 4096}


@pytest.mark.parametrize(
    ("entry", "raw"),
    [
        ({"unit": "deg", "wrap": 360}, np.mod(np.degrees(ANGLE), 360.0)),
        ({"unit": "rad", "wrap": "rev"}, np.mod(ANGLE + math.pi, math.tau) - math.pi),
        ({"unit": "rev", "wrap": "rev"}, np.mod(ANGLE / math.tau, 1.0)),
        ({"unit": "deg", "scale": 0.1, "wrap": "rev"}, np.mod(10.0 * np.degrees(ANGLE), 3600.0)),
        (
            {"unit": "counts", "counts_per_rev": 1e4, "wrap": "16bit", "sign": -1},
            np.mod(np.round(-ANGLE * 1e4 / math.tau) + 2**15, 2**16) - 2**15,
        ),
        (
            {"unit": "counts", "counts_per_rev": 1e4, "wrap": "signed 16bit"},
            np.mod(np.round(ANGLE * 1e4 / math.tau), 2**16),
        ),
    ],
)
def test_a_map_makes_whole_in_the_fields_own_unit(
    tmp_path: Path, entry: dict, raw: np.ndarray
) -> None:
    """Number, bits or one revolution: scaled to rad, the angle is the one before it wrapped."""
    path = table(tmp_path / "a.csv", t=TIME, q=raw)
    tree = {"signals": {"rotor_position": {"field": "q", **entry}}}
    found = read_mapped(path, parse_map(tree, "m")).rotor_position_rad
    off = found - ANGLE
    np.testing.assert_allclose(off, off[0], atol=math.tau / 1e4)
    turns = off[0] / math.tau
    assert abs(turns - round(turns)) < 1e-3


def test_an_encoder_of_one_turn_begins_within_half_a_turn_of_zero(tmp_path: Path) -> None:
    """One that stands a little below zero reads 359 deg there, and becomes -1 deg, not 359."""
    raw = np.mod(359.0 + 100.0 * np.sin(3.0 * TIME), 360.0)
    path = table(tmp_path / "a.csv", t=TIME, q=raw)
    tree = {"signals": {"rotor_position": {"field": "q", "unit": "deg", "wrap": 360}}}
    found = read_mapped(path, parse_map(tree, "m")).rotor_position_rad
    np.testing.assert_allclose(np.degrees(found), -1.0 + 100.0 * np.sin(3.0 * TIME), atol=1e-9)


def test_the_sign_of_an_effort_is_mended_and_no_more(tmp_path: Path) -> None:
    """Two's complement read unsigned becomes negative; a current does not go on past its range."""
    current = np.round(3000.0 * np.sin(3.0 * TIME))
    path = table(tmp_path / "a.csv", t=TIME, i=np.mod(current, 65_536))
    tree = {"signals": {"current_q": {"field": "i", "unit": "mA", "wrap": "signed 16bit"}}}
    found = read_mapped(path, parse_map(tree, "m")).current_q_a
    np.testing.assert_allclose(found, 1e-3 * current, rtol=1e-12)


def test_a_wrap_that_the_map_does_not_mend_is_noted(tmp_path: Path) -> None:
    """Read without the key the leaps stay, and the note says which key makes them whole."""
    path = table(tmp_path / "a.csv", t=TIME, q=np.mod(np.degrees(ANGLE), 360.0))
    tree = {"signals": {"rotor_position": {"field": "q", "unit": "deg"}}}
    (note,) = read_mapped(path, parse_map(tree, "m")).notes
    assert "rotor_position: goes from one end" in note and "wrap: 360" in note


def test_a_field_too_fast_to_be_made_whole_is_noted(tmp_path: Path) -> None:
    """Steps of more than a quarter turn leave open which way it went, and the note says so."""
    fast = np.cumsum(np.full(400, 0.4 * math.tau))
    path = table(tmp_path / "a.csv", t=np.arange(400) * 1e-3, q=np.mod(fast, math.tau))
    tree = {"signals": {"rotor_position": {"field": "q", "wrap": "rev"}}}
    notes = read_mapped(path, parse_map(tree, "m")).notes
    assert any("more than a quarter of rev" in note for note in notes)


def test_inspect_tells_of_wraps(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Text and JSON of `ecyl inspect` name the field, how often it starts again, and the key."""
    times = int((np.abs(np.diff(np.mod(ANGLE, math.tau))) > 3.0).sum())
    path = table(tmp_path / "a.csv", t=TIME, motor_angle_rad=np.mod(ANGLE, math.tau))
    assert main(["inspect", str(path), "--json", str(tmp_path / "a.json")]) == 0
    assert f"to the other {times} times, as a field that wraps around after rev does" in (
        capsys.readouterr().out
    )
    (topic,) = json.loads((tmp_path / "a.json").read_text())["topics"]
    assert topic["fields"][1]["wrap"] == {"wrap": "rev", "times": times}


@pytest.mark.parametrize(
    ("entry", "said"),
    [
        ({"wrap": 0}, "wrap: is 0, expected a number above 0"),
        ({"wrap": "often"}, "wrap: is often, expected a number above 0"),
        ({"wrap": True}, "wrap: is True"),
        ({"wrap": "99bit"}, "wrap: is 99bit"),
    ],
)
def test_a_wrap_that_says_nothing_is_refused(entry: dict, said: str) -> None:
    """Numbers not above 0 and words of no meaning are named."""
    with pytest.raises(InputError, match=said):
        parse_map({"signals": {"rotor_position": {"field": "q", **entry}}}, "m")


def test_a_wrap_of_what_does_not_go_on_is_refused() -> None:
    """A speed or a current does not start again, and a length has no revolution."""
    with pytest.raises(InputError, match="a current does not start again"):
        parse_map({"signals": {"current_q": {"field": "i", "wrap": 4096}}}, "m")
    with pytest.raises(InputError, match="is rev, but the signal is a length"):
        parse_map({"signals": {"rod_position": {"field": "x", "wrap": "rev"}}}, "m")
    assert parse_wrap("4096") == parse_wrap(4096)
