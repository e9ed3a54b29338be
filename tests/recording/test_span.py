"""`--from` and `--to`: the part of a recording that is looked at."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from recording_samples import assert_same, made

from ecyl_ros.cli.main import main
from ecyl_ros.errors import InputError
from ecyl_ros.recording.load import LongRecording, load_long, load_recording, load_stretch
from ecyl_ros.recording.span import Span
from ecyl_ros.recording.survey import survey
from ecyl_ros.recording.writer import write_recording


@pytest.mark.parametrize(
    ("flags", "said"),
    [
        (["--from", "-1"], "--from is -1 s, expected 0 or more"),
        (["--to", "0"], "--to is 0 s, expected more than 0"),
        (["--from", "3", "--to", "2"], "--from is 3 s and --to 2 s"),
        (["--from", "2", "--to", "2"], "--from is 2 s and --to 2 s"),
        (["--from", "nan"], "--from is nan s"),
        (["--from", "9"], "no samples from 9 s to the end"),
    ],
)
@pytest.mark.parametrize("verb", ["inspect", "diagnose"])
def test_a_span_that_holds_nothing_is_refused_in_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], verb: str, flags: list[str], said: str
) -> None:
    """Negative, reversed, empty and beyond the end: exit 2 and one line that says which."""
    write_recording(made(500), tmp_path / "a.mcap")
    drive = ["--drive", "bench"] if verb == "diagnose" else []
    assert main([verb, str(tmp_path / "a.mcap"), *drive, *flags]) == 2
    (line,) = capsys.readouterr().err.strip().splitlines()
    assert said in line


def test_a_span_is_the_recordings_own_samples(tmp_path: Path) -> None:
    """From 0.1 s to 0.3 s are samples 100 to 299, read whole or streamed, and a note says so."""
    recording = made(500)
    write_recording(recording, tmp_path / "a.mcap")
    for read in (load_recording, lambda p, m, s: load_stretch(p, m, 40.0, span=s)):
        part = read(tmp_path / "a.mcap", None, Span(0.1, 0.3))
        assert_same(part, recording.slice(0.1, 0.3))
        assert "only from 0.1 s to 0.3 s was read" in part.notes[0]


def test_a_span_of_a_large_bag_is_streamed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a bag too large to be read whole the span alone is read, or stretches within it taken."""
    recording = made(6_000)
    write_recording(recording, tmp_path / "a.mcap")
    monkeypatch.setattr("ecyl_ros.recording.load.WHOLE_BYTES", 0)
    part = load_long(tmp_path / "a.mcap", None, 2.0, 2, span=Span(1.0, 2.5))
    assert_same(part, recording.slice(1.0, 2.5))  # type: ignore[arg-type]
    found = load_long(tmp_path / "a.mcap", None, 1.0, 3, span=Span(2.0, 5.0))
    assert isinstance(found, LongRecording)
    for one in found.stretches.chosen:
        assert one.begin_s >= 2.0 and one.end_s <= 5.05
        own = found.read(one)
        assert_same(own, recording.slice(one.begin_s, one.end_s))
    with pytest.raises(InputError, match="no samples from 7 s"):
        load_long(tmp_path / "a.mcap", None, 2.0, 2, span=Span(7.0, 8.0))


def test_inspect_looks_at_the_span_alone(tmp_path: Path) -> None:
    """Counts and ranges are those of the samples within, of bags and of tables."""
    recording = made(500)
    write_recording(recording, tmp_path / "a.mcap")
    rows = "\n".join(f"{i * 1e-3},{v!r}" for i, v in enumerate(recording.rod_position_m.tolist()))
    (tmp_path / "a.csv").write_text(f"t,rod\n{rows}\n")
    inside = recording.slice(0.2, 0.4).rod_position_m
    topics = {one.name: one for one in survey(tmp_path / "a.mcap", Span(0.2, 0.4)).topics}
    fields = {one.path: one for one in topics["/ecyl/joint_states"].fields}
    (table,) = survey(tmp_path / "a.csv", Span(0.2, 0.4)).topics
    for found in (fields["position[1]"], table.fields[1]):
        assert (found.count, found.low, found.high) == (200, inside.min(), inside.max())
    assert table.stamps is not None and table.stamps.count == 200
    np.testing.assert_allclose(table.fields[0].low, 0.2)
