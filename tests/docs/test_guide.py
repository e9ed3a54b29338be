"""The user guide: what it tells a newcomer to type is accepted, and prints what it says."""

from __future__ import annotations

import math
import re
import subprocess
import sys
from pathlib import Path

import pytest

from ecyl_ros.cli.main import main
from ecyl_ros.drive.drive_file import load_drive
from ecyl_ros.drive.stability import check_stability

ROOT = Path(__file__).parents[2]
GUIDE = (ROOT / "docs" / "guide.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"^```\n(.*?)^```", GUIDE, re.MULTILINE | re.DOTALL)
FULL, RIGID = (block for block in BLOCKS if block.startswith("/**:"))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The recordings of the guide's example, and its two drive files."""
    out = tmp_path_factory.mktemp("guide")
    subprocess.run([sys.executable, ROOT / "bags" / "other_machine.py", out], check=True)
    (out / "drive.yaml").write_text(FULL, encoding="utf-8")
    (out / "rigid.yaml").write_text(RIGID, encoding="utf-8")
    return out


def test_the_map_in_the_guide_is_the_one_proposed(folder: Path) -> None:
    """`ecyl inspect` proposes for the guide's CSV what the guide prints."""
    assert (
        main(["inspect", str(folder / "drive.csv"), "--write-map", str(folder / "map.yaml")]) == 0
    )
    proposed = (folder / "map.yaml").read_text(encoding="utf-8")
    printed = next(block for block in BLOCKS if "schema: ecyl.map/1" in block)
    assert printed.split("\n", 1)[1] == proposed.split("\n", 1)[1]  # the first line names the file


def test_the_data_sheet_of_the_guide_makes_a_sound_drive(folder: Path) -> None:
    """The full drive file of the guide loads, and its loop is stable."""
    drive = load_drive(folder / "drive.yaml")
    check_stability(drive, "drive.yaml")
    assert drive.transmission.contact_damping == 0.0 and math.isinf(drive.controller.current_limit)


def test_the_rigid_file_of_the_guide_leads_to_its_answer(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """From CSV to a report by the rigid file: the cause and its value are those printed."""
    report = folder / "report.html"
    main(["inspect", str(folder / "drive.csv"), "--write-map", str(folder / "again.yaml")])
    capsys.readouterr()
    arguments = ["--map", folder / "again.yaml", "--drive", folder / "rigid.yaml"]
    words = ["diagnose", folder / "drive.csv", *arguments, "--report", report]
    assert main([str(word) for word in words]) == 0
    said = capsys.readouterr().out
    first = re.match(r"The gap is .*?: [0-9.]+ kN s/m", said, re.DOTALL)
    assert first is not None and first[0] in GUIDE
    assert "viscous friction" in report.read_text(encoding="utf-8").lower()
