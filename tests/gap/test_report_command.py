"""`ecyl diagnose`: flags, refusals, what is written."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from report_samples import coulomb, diagnosis

from ecyl_ros.api import diagnosing as module
from ecyl_ros.cli.main import main
from ecyl_ros.drive.drive_file import config_folder, load_drive
from ecyl_ros.gap.diagnosis import Diagnosis
from ecyl_ros.recording.signals import Recording
from ecyl_ros.recording.writer import write_recording


@pytest.fixture
def recording(tmp_path: Path) -> Path:
    """A recording at rest, enough to be read."""
    stamps = np.arange(50, dtype=np.int64) * 1_000_000
    rest = np.zeros(50)
    path = tmp_path / "rest.mcap"
    write_recording(
        Recording(stamp_ns=stamps, reference_position_m=rest, rotor_position_rad=rest), path
    )
    return path


@pytest.fixture
def said(monkeypatch: pytest.MonkeyPatch) -> list[dict[str, Any]]:
    """Puts an explained gap in the place of a diagnosis; holds what it was called with."""
    calls: list[dict[str, Any]] = []

    def canned(recording: Recording, drive: Any, **options: Any) -> Diagnosis:
        calls.append(options)
        options["progress"](1.0)
        return diagnosis("explained", (coulomb(),), source=options["source"])

    monkeypatch.setattr(module, "judge", canned)
    return calls


def test_all_outputs_are_written_and_named(
    recording: Path, said: list, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """JSON, page and drive file are there, stdout names them, stderr is quiet."""
    outputs = [tmp_path / name for name in ("a.json", "a.html", "a.yaml")]
    flags = [
        word
        for flag, path in zip(("--json", "--report", "--write-drive"), outputs, strict=True)
        for word in (flag, str(path))
    ]
    assert main(["diagnose", str(recording), "--drive", "bench", *flags]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    assert "/ecyl/current: no such topic" in out
    assert [line.split()[1] for line in out.splitlines() if line.startswith("written")] == [
        str(path) for path in outputs
    ]
    data = json.loads(outputs[0].read_text())
    assert data["schema"] == "ecyl.diagnosis/1" and data["verdict"] == "explained"
    assert "explained by" in outputs[1].read_text(encoding="utf-8")
    effects = load_drive(outputs[2]).effects
    assert effects["rotor_coulomb_friction"]["coulomb_nm"] == 0.38023636
    assert said[0]["source"] == str(recording)
    assert said[0]["drive_name"].endswith("bench.yaml")


@pytest.mark.parametrize("flag", ["--json", "--report", "--write-drive"])
def test_an_existing_output_is_refused_before_any_work(
    flag: str, recording: Path, said: list, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """An existing file stays as it is, the refusal names flag and file, nothing is diagnosed."""
    taken = tmp_path / "taken.out"
    taken.write_text("mine")
    words = ["diagnose", str(recording), "--drive", "bench", flag, str(taken)]
    assert main(words) == 2
    err = capsys.readouterr().err
    assert err.count("\n") == 1 and flag in err and str(taken) in err
    assert taken.read_text() == "mine" and not said
    assert main([*words, "--overwrite"]) == 0
    assert taken.read_text() != "mine"


def test_an_output_may_not_be_an_input_or_another_output(
    recording: Path, said: list, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Not even with --overwrite is the recording, the drive file or another output replaced."""
    drive = tmp_path / "drive.yaml"
    drive.write_bytes((config_folder() / "bench.yaml").read_bytes())
    kept = recording.read_bytes(), drive.read_bytes()
    base = ["diagnose", str(recording), "--drive", str(drive), "--overwrite"]
    both = str(tmp_path / "both")
    for extra in (
        ["--json", str(recording)],
        ["--write-drive", str(drive)],
        ["--json", both, "--report", both],
        ["--json", str(tmp_path)],
    ):
        assert main([*base, *extra]) == 2
        assert "expected" in capsys.readouterr().err
    assert (recording.read_bytes(), drive.read_bytes()) == kept and not said


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (["nowhere.mcap", "--drive", "bench"], "nowhere.mcap"),
        (["{recording}", "--drive", "nowhere.yaml"], "nowhere.yaml"),
    ],
)
def test_unusable_input_is_one_line_and_exit_2(
    words: list[str], named: str, recording: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A file that is not there is named on one line of stderr."""
    filled = [word.format(recording=recording) for word in words]
    assert main(["diagnose", *filled]) == 2
    out, err = capsys.readouterr()
    assert out == "" and err.count("\n") == 1 and named in err


def test_no_cause_no_drive_file(
    recording: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Without a cause the command says so, writes no drive file, and is done all the same."""
    monkeypatch.setattr(module, "judge", lambda *_, **__: diagnosis("unexplained"))
    out = tmp_path / "twin.yaml"
    words = ["diagnose", str(recording), "--drive", "bench", "--write-drive", str(out)]
    assert main(words) == 0
    assert "no cause was named" in capsys.readouterr().err
    assert not out.exists()


def test_effects_are_left_out_by_name(
    recording: Path, said: list, capsys: pytest.CaptureFixture[str]
) -> None:
    """--without takes names between commas, each once, and the summary says so."""
    flags = ["--drive", "bench", "--without", "cogging_torque, lead_error,cogging_torque"]
    assert main(["diagnose", str(recording), *flags]) == 0
    assert [call["without"] for call in said] == [("cogging_torque", "lead_error")]
    assert "did without cogging_torque and lead_error" in capsys.readouterr().out
