"""`ecyl investigate` as it is typed, on the graph of an emulated drive."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
import yaml

from ecyl_ros.cli.main import main
from ecyl_ros.drive.drive_file import resolve_drive
from ecyl_ros.recording.reader import read_recording


def _changed(tmp_path: Path, group: str, **values: object) -> Path:
    """The bench drive's file with other values in one group."""
    data = yaml.safe_load(resolve_drive("bench").read_text())
    parameters = data["/**"]["ros__parameters"]
    parameters.setdefault(group, {}).update(values)
    path = tmp_path / f"{group}.yaml"
    path.write_text(yaml.safe_dump(data))
    return path


def test_one_motion_of_a_worn_drive_names_what_is_worn(tmp_path: Path) -> None:
    """Played over topics, recorded, diagnosed from the sheet alone: the drag, and its story."""
    worn = _changed(tmp_path, "effects", rotor_coulomb_friction={"coulomb_nm": 0.3})
    out = tmp_path / "found"
    line = ["investigate", "--drive", "bench", "--emulate", str(worn), "--out", str(out)]
    assert main([*line, "--motions", "1", "--duration", "2"]) in (0, 3)
    story = json.loads((out / "investigation.json").read_text())
    (step,) = story["steps"]
    assert step["causes"][0] == "rotor_coulomb_friction"
    played = read_recording(out / "motion_1.mcap")
    assert 2.0 < played.duration_s < 3.5  # with a moment of rest at either end
    assert (out / "index.html").exists() and (out / "motion_1.html").exists()


def test_an_emulated_drive_that_cannot_run_is_refused_before_anything_starts(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """An unstable loop: exit 2, one line, no folder."""
    unstable = _changed(tmp_path, "controller", current={"kp": 1e4, "ki": 0.0})
    out = tmp_path / "found"
    line = ["investigate", "--drive", "bench", "--emulate", str(unstable), "--out", str(out)]
    assert main(line) == 2
    assert capsys.readouterr().err.count("\n") == 1
    assert not out.exists()
