"""Stretches that say nothing: frozen signals, a logger that repeats, cut ends, full counters."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.io import loadmat, savemat

from ecyl_ros.cli.main import main
from ecyl_ros.recording.flaws import CUT_END, FROZEN, REPEATED, SATURATED, find_flaws
from ecyl_ros.recording.load import load_recording
from ecyl_ros.recording.map_file import parse_map
from ecyl_ros.recording.mapped import read_mapped
from ecyl_ros.recording.signals import Recording
from ecyl_ros.recording.survey import survey
from ecyl_ros.recording.writer import write_recording

SHARED = Path(__file__).parents[3] / "shared" / "field"
RATE = 1000
STEP_RAD = 2.0 * np.pi / 4096  # of a 12 bit encoder


def moves(seconds: float = 8.0) -> dict[str, np.ndarray]:
    """Out and back with dwells of 0.7 s: command, coarse encoder, speed and current with noise."""
    time = np.arange(round(seconds * RATE)) / RATE
    random = np.random.default_rng(3)
    phase = np.mod(time, 2.0)
    ramp = np.clip(phase / 0.65, 0.0, 1.0) - np.clip((phase - 1.0) / 0.65, 0.0, 1.0)
    smooth = 3.0 * ramp**2 - 2.0 * ramp**3
    angle = 20.0 * smooth
    speed = np.gradient(angle, time)
    current = 0.02 * np.gradient(speed, time) + 0.3 * np.tanh(speed)
    return {
        "time": time,
        "reference": angle,
        "encoder": STEP_RAD * np.round((angle - 0.004 * speed) / STEP_RAD),
        "speed": speed + random.normal(scale=0.05, size=time.size),
        "current": np.round(current + random.normal(scale=0.02, size=time.size), 4),
    }


def stamps(columns: dict[str, np.ndarray]) -> np.ndarray:
    return np.round(columns["time"] * 1e9).astype(np.int64)


def flaws(columns: dict[str, np.ndarray]) -> list:
    values = {name: own for name, own in columns.items() if name != "time"}
    return find_flaws(stamps(columns), values, held=("reference",))


def write(path: Path, columns: dict[str, np.ndarray]) -> None:
    rows = zip(*(values.tolist() for values in columns.values()), strict=True)
    text = "\n".join(",".join(repr(cell) for cell in row) for row in rows)
    path.write_text(f"{','.join(columns)}\n{text}\n")


TREE = {
    "time": "time",
    "signals": {
        "reference_position": {"field": "reference", "unit": "rad"},
        "rotor_position": "encoder",
        "rotor_velocity": "speed",
        "current_q": "current",
    },
}


def test_a_sound_drive_has_no_flaw() -> None:
    """Dwells of a coarse encoder and of the command are no frozen stretches: nothing is found."""
    assert flaws(moves()) == []


def test_a_drive_switched_off_is_no_flaw() -> None:
    """A current that is exactly 0 for 2 s of rest, and one at its limit, are as they should be."""
    columns = moves()
    columns["current"][5_650:6_000] = 0.0
    columns["speed"] = np.clip(columns["speed"], -20.0, 20.0)
    assert flaws(columns) == []


def test_an_output_that_sticks_is_no_flaw() -> None:
    """A coarse position that stands through each reversal of its drive, as play makes it, stays."""
    columns = moves()
    angle, out, held = columns["encoder"], np.empty(8000), 0.0
    for i, value in enumerate(angle):
        held = min(max(held, value - 2.0), value + 2.0)
        out[i] = held
    columns["output"] = 1e-3 * np.round(out)
    columns["coarse"] = 0.5 * np.round(out / 0.5)
    assert flaws(columns) == []


@pytest.mark.parametrize(
    ("begin", "end"), [(2_100, 2_400), (700, 950), (5_000, 5_060), (7_700, 8_000)]
)
def test_a_frozen_current_is_found_to_the_sample(begin: int, end: int) -> None:
    """Noise that rests, moving or not, inside or at the end, is found with its exact rows."""
    columns = moves()
    columns["current"][begin:end] = columns["current"][begin]
    (found,) = flaws(columns)
    assert (found.kind, found.fields) == (FROZEN, ("current",))
    assert (found.begin, found.end) == (begin, end)


def test_a_frozen_coarse_encoder_is_found_by_its_leap() -> None:
    """A coarse encoder without noise is frozen where it leaps on to where the motion went."""
    columns = moves()
    columns["encoder"][2_100:2_300] = columns["encoder"][2_100]
    (found,) = flaws(columns)
    assert (found.kind, found.fields) == (FROZEN, ("encoder",))
    # Before it was frozen it may have stood for a sample or two by its coarse steps.
    assert 2_098 <= found.begin <= 2_100 and found.end == 2_300


@pytest.mark.parametrize(("named", "derivative"), [("voltage", 0.0), ("u", 0.0), ("u", 60.0)])
def test_an_effort_worked_out_of_a_coarse_position_is_no_evidence(
    named: str, derivative: float
) -> None:
    """A proportional loop on a coarse encoder, with a difference or without, and whatever its
    effort is called: at rest all stands still, and the effort leaps at the next step."""
    asked = np.repeat([0.0, 1.0, 0.2, 0.9, -0.3, 0.5], 1500)
    place, made = np.zeros(asked.size), 0.0
    for row in range(1, asked.size):
        made += 0.02 * (asked[row - 1] - place[row - 1])
        place[row] = np.round(made / 1e-3) * 1e-3
    off = asked - place
    effort = 40.0 * off + derivative * np.diff(off, prepend=0.0)
    time = np.arange(asked.size) / RATE
    columns = {"time": time, "position": place, named: effort, "reference": asked}
    assert flaws(columns) == []


def test_a_logger_that_repeats_costs_all_signals() -> None:
    """Where every signal stands, the command too, a sample was repeated: all are left out."""
    columns = moves()
    for name in ("reference", "encoder", "speed", "current"):
        columns[name][4_200:4_350] = columns[name][4_200]
    (found,) = flaws(columns)
    assert found.kind == REPEATED
    assert set(found.fields) == {"reference", "encoder", "speed", "current"}
    assert (found.begin, found.end) == (4_200, 4_350)


def test_a_sample_repeated_a_few_times_is_found_too() -> None:
    """Eight rows of all signals alike in the midst of a motion: all of them left out, once; as many
    equal rows of the coarse encoder alone are none."""
    columns = moves()
    at = 2300
    for name in ("reference", "encoder", "speed", "current"):
        columns[name][at : at + 8] = columns[name][at]
    (found,) = flaws(columns)
    assert (found.kind, found.begin, found.end) == (REPEATED, at, at + 8)
    alone = moves()
    alone["encoder"][at : at + 8] = alone["encoder"][at]
    assert flaws(alone) == []


def test_rows_of_zeros_at_the_end_are_cut_off() -> None:
    """A buffer's empty rows are no motion to 0; a run that ends at rest at 0 is whole."""
    columns = moves(7.5)
    whole = {name: values.copy() for name, values in columns.items()}
    for name in ("reference", "encoder", "speed", "current"):
        columns[name][-37:] = 0.0
    (found,) = flaws(columns)
    assert (found.kind, found.samples, found.end) == (CUT_END, 37, 7_500)
    rest = {name: values * (whole["time"] < 7.4) for name, values in whole.items()}
    rest |= {"time": whole["time"], "speed": whole["speed"]}
    assert flaws(rest) == []


def test_a_counter_at_the_end_of_its_range_is_saturated() -> None:
    """A 16 bit position that runs into 32767 and rests there says nothing there; one below does."""
    time = np.arange(4000) / RATE
    counts = np.round(34_000 * np.sin(2.0 * np.pi * 0.5 * time))
    columns = {"time": time, "position": np.minimum(counts, 32_767.0)}
    (found,) = find_flaws(stamps(columns), {"position": columns["position"]})
    assert (found.kind, found.value) == (SATURATED, 32_767.0)
    assert found.samples == int((counts >= 32_767).sum())
    high = float(np.round(30_000 * np.sin(1.0)))
    clipped = np.minimum(counts, high)
    assert find_flaws(stamps(columns), {"position": clipped}) == []
    # What comes to rest at the number by slowing down has merely stopped there.
    stops = np.round(
        32_767 * np.clip(time / 2.0, 0, 1) ** 0.5 * (2 - np.clip(time / 2.0, 0, 1)) ** 0.5
    )
    assert find_flaws(stamps(columns), {"position": stops}) == []


def test_what_is_left_out_is_noted_and_the_rest_kept(tmp_path: Path) -> None:
    """By a map the frozen rows are NaN, the note names their seconds, and no other row changes."""
    columns = moves()
    expected = read(tmp_path, columns)
    columns["speed"][2_100:2_400] = columns["speed"][2_100]
    found = read(tmp_path, columns)
    rows = np.flatnonzero(np.isnan(found.rotor_velocity_rad_per_s))
    np.testing.assert_array_equal(rows, np.arange(2_100, 2_400))
    kept = np.ones(8000, dtype=bool)
    kept[rows] = False
    np.testing.assert_array_equal(
        found.rotor_velocity_rad_per_s[kept], expected.rotor_velocity_rad_per_s[kept]
    )
    np.testing.assert_array_equal(found.rotor_position_rad, expected.rotor_position_rad)
    (note,) = found.notes
    assert "rotor_velocity: frozen" in note and "from 2.100 s to 2.399 s: left out" in note


def read(tmp_path: Path, columns: dict[str, np.ndarray]) -> Recording:
    write(tmp_path / "a.csv", columns)
    return read_mapped(tmp_path / "a.csv", parse_map(TREE, "m"))


def test_a_position_that_stands_while_its_speed_goes_on_is_frozen(tmp_path: Path) -> None:
    """At the end of a file no leap shows it: the same body's speed says that it moved 3 rad."""
    columns = {name: values[:4_300] for name, values in moves().items()}
    columns["encoder"][4_120:] = columns["encoder"][4_120]
    found = read(tmp_path, columns)
    assert np.isnan(found.rotor_position_rad[4_122:]).all()
    assert np.isfinite(found.rotor_position_rad[:4_110]).all()
    assert any("rotor_position: frozen" in note for note in found.notes)


def test_a_rest_whose_speed_reads_an_offset_is_no_flaw(tmp_path: Path) -> None:
    """A drive that rests for 20 s while noise of speed and current runs on: a speed that reads
    0.02 rad/s too much carries nothing, for it does so in motion, too."""
    columns = moves(24.0)
    random = np.random.default_rng(5)
    rest = columns["time"] >= 4.0
    for name in ("reference", "encoder"):
        columns[name][rest] = columns[name][~rest][-1]
    columns["speed"][rest] = random.normal(scale=0.05, size=int(rest.sum()))
    columns["speed"] += 0.02
    columns["current"][rest] = np.round(random.normal(scale=0.02, size=int(rest.sum())), 4)
    assert read(tmp_path, columns).notes == ()


def test_our_own_topics_are_screened_too(tmp_path: Path) -> None:
    """A bag of this project's topics whose current froze loses just these samples, with a note."""
    columns = moves()
    current = columns["current"].copy()
    current[3_000:3_200] = current[3_000]
    recording = Recording(
        stamp_ns=stamps(columns),
        reference_position_m=columns["reference"],
        rotor_position_rad=columns["encoder"],
        rotor_velocity_rad_per_s=columns["speed"],
        current_q_a=current,
    )
    write_recording(recording, tmp_path / "a.mcap")
    found = load_recording(tmp_path / "a.mcap")
    rows = np.flatnonzero(np.isnan(found.current_q_a))
    np.testing.assert_array_equal(rows, np.arange(3_000, 3_200))
    assert any("current_q_a: frozen" in note for note in found.notes)


def test_inspect_tells_flaws_in_text_and_json(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """`ecyl inspect` names signal, kind and seconds of each flaw, and JSON holds the same."""
    columns = moves()
    columns["current"][2_100:2_400] = columns["current"][2_100]
    write(tmp_path / "a.csv", columns)
    assert main(["inspect", str(tmp_path / "a.csv"), "--json", str(tmp_path / "a.json")]) == 0
    assert "current: frozen, the very same value for 300 samples, from 2.100 s to 2.399 s" in (
        capsys.readouterr().out
    )
    (topic,) = json.loads((tmp_path / "a.json").read_text())["topics"]
    (flaw,) = topic["flaws"]
    assert (flaw["kind"], flaw["fields"], flaw["rows"]) == ("frozen", ["current"], [2100, 2400])
    assert (flaw["from_s"], flaw["to_s"]) == (2.1, 2.399)


@pytest.mark.skipif(not SHARED.is_dir(), reason="no ../shared/field beside the repository")
@pytest.mark.parametrize(
    "name",
    [
        "emps/DATA_EMPS.mat",
        "laas_pmsm_cogging/speed_test.txt",
        "laas_pmsm_cogging/speed_test1.txt",
        "sage_so101/triangle_wave",
        "sage_so101/friction_gravity",
        "sage_so101/backlash_detection",
    ],
)
def test_real_drives_as_published_have_no_flaw(name: str) -> None:
    """A screw stage, a brushless motor and servos of 12 bit: nothing frozen, nothing that wraps."""
    assert survey(SHARED / name).flaw_lines() == []


@pytest.mark.skipif(not SHARED.is_dir(), reason="no ../shared/field beside the repository")
def test_a_real_stage_frozen_by_hand_is_found(tmp_path: Path) -> None:
    """The published stage with its position held for 40 ms in motion: found to the sample."""
    raw = loadmat(SHARED / "emps" / "DATA_EMPS.mat")
    columns = {name: np.array(raw[name][:, 0], dtype=float) for name in ("t", "qg", "qm", "vir")}
    columns["qm"][5_200:5_240] = columns["qm"][5_200]
    savemat(tmp_path / "a.mat", columns)
    (topic,) = survey(tmp_path / "a.mat").topics
    (flaw,) = topic.flaws
    assert (flaw.kind, flaw.fields, flaw.begin, flaw.end) == (FROZEN, ("qm",), 5_200, 5_240)


def test_pieces_join_to_the_whole(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Looked through in pieces of a second, the same frozen stretches are found."""
    columns = moves()
    columns["current"][1_900:2_150] = columns["current"][1_900]
    columns["speed"][4_200:4_500] = columns["speed"][4_200]
    write(tmp_path / "a.csv", columns)
    (whole,) = survey(tmp_path / "a.csv").topics
    monkeypatch.setattr("ecyl_ros.recording.health.PIECE_BYTES", 8 * 6 * 1000)
    monkeypatch.setattr("ecyl_ros.recording.csvtext.BLOCK_BYTES", 20_000)
    (pieces,) = survey(tmp_path / "a.csv").topics
    expected = [(one.kind, one.fields, one.begin, one.end) for one in whole.flaws]
    assert expected == [
        (FROZEN, ("current",), 1_900, 2_150),
        (FROZEN, ("speed",), 4_200, 4_500),
    ]
    assert [(one.kind, one.fields, one.begin, one.end) for one in pieces.flaws] == expected


def test_a_rest_before_lost_samples_is_no_flaw() -> None:
    """What rests, loses 0.3 s of samples and has moved since was not frozen."""
    columns = {name: np.delete(values, slice(3_000, 3_300)) for name, values in moves().items()}
    assert flaws(columns) == []


def test_a_smooth_current_that_rests_in_motion_is_frozen() -> None:
    """Without noise to go by, a filtered current that stands while the shaft turns is found."""
    time = np.arange(6000) / RATE
    angle = 6.0 * time + 0.05 * np.sin(40.0 * time)
    current = np.round(0.4 + 0.3 * np.sin(160.0 * time) + 0.1 * np.sin(11.0 * time), 3)
    columns = {"time": time, "encoder": STEP_RAD * np.round(angle / STEP_RAD), "current": current}
    assert flaws(columns) == []
    current[2_000:2_200] = current[2_000]
    (found,) = flaws(columns)
    assert (found.kind, found.fields) == (FROZEN, ("current",))
    assert (found.begin, found.end) == (2_000, 2_200)
    # Where the shaft rests meanwhile, the current may.
    stops = np.cumsum(np.where((time > 1.9) & (time < 2.3), 0.0, np.gradient(angle)))
    at_rest = {**columns, "encoder": STEP_RAD * np.round(stops / STEP_RAD)}
    assert flaws(at_rest) == []
