"""What verbs write never takes the place of what they read, nor of each other's outputs."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ecyl_ros.cli.main import main
from ecyl_ros.drive.drive_file import config_folder
from ecyl_ros.recording.signals import Recording
from ecyl_ros.recording.writer import write_recording


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A recording at rest, a drive file and a map in a folder."""
    stamps = np.arange(50, dtype=np.int64) * 1_000_000
    rest = np.zeros(50)
    recording = Recording(stamp_ns=stamps, reference_position_m=rest, rod_position_m=rest)
    write_recording(recording, tmp_path / "rest.mcap")
    (tmp_path / "drive.yaml").write_bytes((config_folder() / "bench.yaml").read_bytes())
    (tmp_path / "map.yaml").write_text("schema: ecyl.map/1\n", encoding="utf-8")
    return tmp_path


DIAGNOSE = ["diagnose", "rest.mcap", "--drive", "drive.yaml", "--map", "map.yaml"]
SWEEP = ["sensitivity", "--drive", "drive.yaml", "--vary", "stiffness=1"]


@pytest.mark.parametrize(
    ("words", "why"),
    [
        ([*DIAGNOSE, "--json", "rest.mcap"], "--json rest.mcap: is RECORDING rest.mcap too"),
        ([*DIAGNOSE, "--write-drive", "drive.yaml"], "--write-drive drive.yaml: is --drive too"),
        ([*DIAGNOSE, "--report", "map.yaml"], "--report map.yaml: is --map too"),
        ([*DIAGNOSE, "--report", "a", "--json", "a"], "--report a: is --json too"),
        ([*DIAGNOSE, "--write-mcap", "a.bag"], "--write-mcap a.bag: expected a name that ends in"),
        (["inspect", "rest.mcap", "--json", "rest.mcap"], "--json rest.mcap: is FILE too"),
        (["inspect", "rest.mcap", "--write-map", "map.yaml"], "--write-map map.yaml: exists"),
        (["inspect", "rest.mcap", "--write-map", "."], "--write-map .: is a folder"),
        (["analyse", "rest.mcap", "--json", "./rest.mcap"], "--json rest.mcap: is BAG too"),
        ([*SWEEP, "--csv", "drive.yaml"], "--csv drive.yaml: is --drive too"),
        ([*SWEEP, "--csv", "a", "--json", "a"], "--csv a: is --json too"),
        (["bench", "--loop", "map.yaml", "--json", "map.yaml"], "--json map.yaml: is --loop too"),
        (["blind", "--drive", "drive.yaml", "--json", "drive.yaml"], "drive.yaml: is --drive too"),
    ],
)
def test_an_output_that_is_an_input_is_refused_and_left_alone(
    words: list[str],
    why: str,
    folder: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """One line names flag, file and what it is already; exit 2; every file stays as it was."""
    monkeypatch.chdir(folder)
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    extra = ["--cases", "1", "--seed", "1"] if words[0] == "blind" else []
    overwrite = (
        ["--overwrite"] if words[0] in ("diagnose", "inspect") and "exists" not in why else []
    )
    assert main([*words, *extra, *overwrite]) == 2
    out, err = capsys.readouterr()
    assert out == "" and why in err and len(err.splitlines()) == 1
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before
