"""The first command: a worn drive as a graph, recorded, diagnosed, reported."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from ecyl_ros.cli.main import main
from ecyl_ros.drive.drive_file import load_drive
from ecyl_ros.recording.reader import read_recording

README = (Path(__file__).parents[2] / "README.md").read_text(encoding="utf-8")


def _words(text: str) -> str:
    """The text without its numbers, whose last digit may differ from one machine to the next."""
    return re.sub(r"[\d.]+", "#", " ".join(text.split()))


def test_the_demo_finds_the_fault_it_runs(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """It names the wrong backlash, its interval holds the true one, and README prints the same."""
    folder = tmp_path / "demo"
    assert main(["demo", str(folder)]) == 0
    said = capsys.readouterr().out
    sentence = re.search(
        r"The gap is explained by a wrong backlash.*?Confidence 0\.\d\d", said, re.S
    )
    assert sentence is not None and sentence[0] in README
    low, high = (float(one) for one in re.findall(r"\(([\d.]+) to ([\d.]+)\)", said)[0])
    truth = load_drive("worn_1khz").effects["backlash_error"]["backlash_rad"]
    assert low < 1e3 * truth < high
    recording = read_recording(folder / "worn.mcap")
    assert len(recording) == 4000 and round(recording.rate_hz) == 1000
    tracking = re.search(r"  The rod follows .*", said)
    assert tracking is not None and tracking[0] in README  # the graph gives the same bytes anywhere
    assert "wrong backlash" in (folder / "worn.html").read_text(encoding="utf-8")
    assert list((folder / "worn_plots").glob("*.png"))
    assert main(["demo", str(folder)]) == 2
    assert "--overwrite" in capsys.readouterr().err
