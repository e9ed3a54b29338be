import io
import json

import numpy as np
import pytest

from ecyl_ros.analysis.report import as_json, print_analysis
from ecyl_ros.analysis.tracking import analyse
from ecyl_ros.cli.main import main
from ecyl_ros.errors import InputError
from ecyl_ros.recording import Recording
from ecyl_ros.recording.reader import read_recording
from ecyl_ros.recording.writer import write_recording

TIME = np.arange(8000) / 1000.0
REFERENCE = 2e-5 * np.sin(2 * np.pi * TIME)
POSITION = 1.9e-5 * np.sin(2 * np.pi * (TIME - 0.019)) + 5e-6 * np.sin(2 * np.pi * 3.45 * TIME)
KEYS = {"error_std_m", "error_rms_m", "lag_s", "gain", "spectrum", "imfs"}


def recorded(**signals) -> Recording:
    """Eight seconds at 1 kHz."""
    return Recording(stamp_ns=np.arange(TIME.size) * 1_000_000, **signals)


def tracked(**more) -> Recording:
    """A sine followed late, with a swing of 3.45 Hz on top."""
    return recorded(reference_position_m=REFERENCE, rod_position_m=POSITION, **more)


def test_figures_of_a_known_motion():
    """Error, lag and lines of two sines come out as their closed forms."""
    figures = analyse(tracked(), 1.0)
    error = (REFERENCE - POSITION)[TIME >= 1.0]
    assert figures.error_std_m == pytest.approx(error.std(), rel=1e-12)
    assert figures.error_rms_m == pytest.approx(np.sqrt(np.mean(error**2)), rel=1e-12)
    assert figures.error_max_m == np.abs(error).max()
    assert figures.lag.lag_s == pytest.approx(0.019, abs=2e-3)
    assert figures.lag.gain == pytest.approx(0.95, abs=0.02)
    slow = 1e-5 * abs(2 - 1.9 * np.exp(-2j * np.pi * 0.019))  # amplitude of the 1 Hz part
    assert [line.frequency_hz for line in figures.lines] == pytest.approx([3.45, 1.0], abs=2e-3)
    assert [line.amplitude for line in figures.lines] == pytest.approx([5e-6, slow], rel=0.01)
    assert figures.emd.imfs[0].frequency_hz == pytest.approx(3.45, abs=0.02)
    assert figures.duration_s == pytest.approx(6.999)


def test_missing_signals_are_refused_by_name():
    """No reference, no rod: each is refused under its own name."""
    with pytest.raises(InputError, match="reference_position_m"):
        analyse(recorded(rod_position_m=POSITION))
    with pytest.raises(InputError, match=r"rod_position_m is not measured.*rotor-to-rod"):
        analyse(recorded(reference_position_m=REFERENCE, rotor_position_rad=POSITION))
    with pytest.raises(InputError, match="neither"):
        analyse(recorded(reference_position_m=REFERENCE), rotor_to_rod_m_per_rad=1.0)


def test_the_rotor_stands_in_for_the_rod_only_when_told_so():
    """With the factor given, the rotor's angle gives the figures, and a note says so."""
    factor = 0.02 / (2 * np.pi * 2.16)
    recording = recorded(reference_position_m=REFERENCE, rotor_position_rad=POSITION / factor)
    figures = analyse(recording, rotor_to_rod_m_per_rad=factor)
    assert figures.error_std_m == pytest.approx(analyse(tracked()).error_std_m, rel=1e-9)
    assert any("taken from rotor_position_rad" in note for note in figures.notes)
    with pytest.raises(InputError, match="factor is 0"):
        analyse(recording, rotor_to_rod_m_per_rad=0.0)


@pytest.mark.parametrize("skip", [8.0, 7.99, -1.0, float("nan")])
def test_a_skip_that_leaves_nothing_is_refused(skip):
    """A skip beyond the end, nearly so, below zero or NaN is refused by name."""
    with pytest.raises(InputError, match="skip is"):
        analyse(tracked(), skip)


def test_dropped_and_jittered_samples_do_not_change_the_figures():
    """Half the samples dropped at random: figures within 3 %, and a note that says interpolated."""
    keep = np.random.default_rng(0).random(TIME.size) < 0.5
    recording = Recording(
        stamp_ns=(np.arange(TIME.size) * 1_000_000)[keep],
        reference_position_m=REFERENCE[keep],
        rod_position_m=POSITION[keep],
    )
    whole, part = analyse(tracked()), analyse(recording)
    assert part.error_std_m == pytest.approx(whole.error_std_m, rel=0.03)
    assert part.lag.lag_s == pytest.approx(whole.lag.lag_s, abs=5e-4)
    assert part.lines[0].frequency_hz == pytest.approx(3.45, abs=5e-3)
    assert any("uneven" in note for note in part.notes)


def test_samples_without_a_reference_are_left_out_and_noted():
    """NaN in the reference takes that sample out of the figures."""
    reference = REFERENCE.copy()
    reference[100:200] = np.nan
    figures = analyse(recorded(reference_position_m=reference, rod_position_m=POSITION))
    assert figures.samples == TIME.size - 100
    assert np.isfinite(figures.error_std_m)
    assert any("7900 of 8000" in note for note in figures.notes)


def test_a_still_reference_gives_null_with_the_reason():
    """Holding position: error figures as ever, lag and gain null in the JSON, and why."""
    figures = analyse(recorded(reference_position_m=np.zeros(TIME.size), rod_position_m=POSITION))
    result = json.loads(json.dumps(as_json(figures), allow_nan=False))
    assert result["lag_s"] is None and result["gain"] is None
    assert result["lag_reason"] == "the reference never moves"
    assert result["error_std_m"] == pytest.approx(POSITION.std())


def test_a_perfect_follower_has_no_lines_and_no_modes():
    """Zero error is no division by zero."""
    figures = analyse(recorded(reference_position_m=REFERENCE, rod_position_m=REFERENCE))
    assert (figures.error_max_m, figures.lines, figures.emd.imfs) == (0.0, (), ())
    assert figures.lag.lag_s == pytest.approx(0.0, abs=1e-9)
    print_analysis(figures, io.StringIO())


def test_the_table_in_a_pipe_is_plain_text():
    """Without a terminal there is no escape code, and every figure is in it."""
    out = io.StringIO()
    print_analysis(analyse(tracked()), out)
    text = out.getvalue()
    assert "\x1b" not in text and text.isascii()
    for word in ("error std", "lag", "Spectrum", "Empirical", "3.450"):
        assert word in text


def test_the_verb_writes_its_json_and_plots(tmp_path, capsys):
    """`ecyl analyse` exits 0, writes the contract's keys and the figures, and prints the table."""
    load = POSITION * 600
    recording = tracked(
        rotor_position_rad=load + 1e-3 * np.sin(2 * np.pi * 3.45 * TIME), load_position_rad=load
    )
    write_recording(recording, tmp_path / "bag")
    out, plots = tmp_path / "deep" / "o.json", tmp_path / "plots"
    arguments = ["analyse", str(tmp_path / "bag"), "--skip", "1"]
    assert main([*arguments, "--json", str(out), "--plots", str(plots)]) == 0
    result = json.loads(out.read_text())
    assert set(result) > KEYS
    assert set(result["spectrum"][0]) == {"frequency_hz", "amplitude_m"}
    assert set(result["imfs"][0]) > {"frequency_hz", "amplitude_m", "std_m"}
    names = {path.name for path in plots.iterdir()}
    assert names >= {
        "position.png",
        "error.png",
        "spectrum.png",
        "imf_1.png",
        "imf_2.png",
        "relative_angle.png",
    }
    for path in plots.iterdir():
        assert path.read_bytes().startswith(b"\x89PNG") and path.stat().st_size > 10_000
    captured = capsys.readouterr()
    assert "error std" in captured.out and "/ecyl/current: no such topic" in captured.err


def test_the_verb_refuses_in_one_line_and_leaves_no_file(tmp_path, capsys):
    """Bad files and flags: exit 2, one line on stderr that names the file, no JSON, no plots."""
    write_recording(tracked(), tmp_path / "a.mcap")
    (tmp_path / "b.mcap").write_text("no")
    (tmp_path / "file").write_text("")
    before = sorted(tmp_path.iterdir())
    for arguments in (
        ["a.mcap", "--skip", "99", "--json", "o.json", "--plots", "p"],
        ["b.mcap", "--json", "o.json", "--plots", "p"],
        ["c.mcap", "--json", "o.json"],
        ["a.mcap", "--json", "file/o.json"],
        ["a.mcap", "--plots", "file"],
    ):
        paths = [str(tmp_path / x) if "." in x or x in ("file", "p") else x for x in arguments]
        assert main(["analyse", *paths]) == 2
        err = capsys.readouterr().err.splitlines()
        last = [line for line in err if "no such topic" not in line]
        assert len(last) == 1 and str(tmp_path) in last[0]
    assert sorted(tmp_path.iterdir()) == before


def test_foreign_recordings_are_analysed(foreign, tmp_path):
    """Every file of another simulator: error as numpy has it, a lag near 1/kp, valid JSON."""
    for path in sorted(foreign.glob("*.mcap")):
        out = tmp_path / f"{path.stem}.json"
        assert main(["analyse", str(path), "--skip", "0.5", "--json", str(out)]) == 0
        result = json.loads(out.read_text(), parse_constant=pytest.fail)
        recording = read_recording(path).slice(0.5)
        error = recording.reference_position_m - recording.rod_position_m
        assert result["error_std_m"] == pytest.approx(error.std(), rel=1e-12)
        assert result["error_rms_m"] == pytest.approx(np.sqrt((error**2).mean()), rel=1e-12)
        # The drive's position loop has a gain of 40 1/s: 25 ms for slow motion, less for fast.
        assert 0.015 < result["lag_s"] < 0.03
        assert 0.95 < result["gain"] < 1.02
        assert len(result["imfs"]) >= 3 and result["spectrum"]


def test_the_verb_gives_the_line_asked_for_or_refuses(tmp_path, capsys):
    """--line 3.45 gives the swing's 5 um; with two seconds left, --line 1 is refused by name."""
    write_recording(tracked(), tmp_path / "a.mcap")
    out = tmp_path / "o.json"
    command = ["analyse", str(tmp_path / "a.mcap"), "--json", str(out)]
    assert main([*command, "--line", "3.45"]) == 0
    assert json.loads(out.read_text())["asked_line"]["amplitude_m"] == pytest.approx(5e-6, rel=0.01)
    assert "line asked for" in capsys.readouterr().out
    out.unlink()
    assert main([*command, "--skip", "6", "--line", "1"]) == 2
    assert "too short for a line at 1 Hz" in capsys.readouterr().err
    assert not out.exists()
