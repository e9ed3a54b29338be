"""A folder of recordings, each diagnosed by itself."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import pytest
from sheets import exact

from ecyl_ros.cli.main import main
from ecyl_ros.drive.engine import simulate
from ecyl_ros.drive.reference.moves import Moves
from ecyl_ros.drive.telemetry import simulation_recording
from ecyl_ros.recording.writer import write_recording


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """One machine recorded twice, and a file that is no recording."""
    made = tmp_path / "fleet"
    made.mkdir()
    drive = exact("bench")
    rate = drive.sample_rate
    moves = Moves((0.004, -0.002), speed=0.05, acceleration=1.0, jerk=50.0)
    run = simulate(drive, lambda index: moves.sample(index / rate), 1.6)
    for number in (1, 2):
        write_recording(simulation_recording(run, drive), made / f"press_{number:02d}.mcap")
    (made / "broken.mcap").write_text("no bag")
    return made


def _run(folder: Path, out: Path, *more: str) -> int:
    words = ["diagnose", str(folder), "--each", "--drive", "bench", "--out", str(out)]
    elsewhere = {"--jobs", "--dask"} & set(more)
    return main([*words, *([] if elsewhere else ["--jobs", "1"]), *more])


def _rows(out: Path) -> list[dict[str, str]]:
    with (out / "index.csv").open(newline="") as lines:
        return list(csv.DictReader(lines))


def test_every_recording_has_its_page_and_a_broken_one_costs_a_line(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Index, pages and data of those that can be read; one line for the other; --resume keeps."""
    out = tmp_path / "out"
    assert _run(folder, out) == 0
    assert "broken: is no MCAP file" in capsys.readouterr().err
    rows = {row["recording"]: row for row in _rows(out)}
    assert {row["verdict"] for name, row in rows.items() if name != "broken"} == {"no_gap"}
    assert rows["press_01"]["machine"] == rows["press_02"]["machine"] == "press"
    assert rows["broken"]["error"] and list(rows)[-1] == "broken"
    page = (out / "index.html").read_text()
    assert 'href="recordings/press_01.html"' in page and "broken" in page
    first = json.loads((out / "recordings" / "press_01.json").read_text())
    second = json.loads((out / "recordings" / "press_02.json").read_text())
    for one in (first, second):
        one.pop("seconds"), one.pop("recording")
    assert first == second  # the same numbers of the same recording

    stamps = {path: path.stat().st_mtime_ns for path in (out / "recordings").glob("*.html")}
    (folder / "press_02.mcap").touch()
    assert _run(folder, out) == 2  # an index is there
    assert _run(folder, out, "--resume") == 0
    redone = {path.name for path, stamp in stamps.items() if path.stat().st_mtime_ns != stamp}
    assert redone == {"press_02.html"}


def _data(out: Path) -> dict[str, dict]:
    """What was written of each recording, less the time that it took."""
    found = {one.name: json.loads(one.read_text()) for one in (out / "recordings").glob("*.json")}
    for one in found.values():
        one.pop("seconds")
    return found


def test_worker_processes_and_a_cluster_give_the_same_numbers(folder: Path, tmp_path: Path) -> None:
    """In this process, in two, and on a Dask worker: the same JSON of every recording."""
    distributed = pytest.importorskip("distributed")
    assert _run(folder, tmp_path / "here") == 0
    here = _data(tmp_path / "here")
    assert len(here) == 2
    assert _run(folder, tmp_path / "two", "--jobs", "2") == 0
    assert _data(tmp_path / "two") == here
    with distributed.LocalCluster(n_workers=1, dashboard_address=None) as cluster:
        assert _run(folder, tmp_path / "dask", "--dask", cluster.scheduler_address) == 0
    assert _data(tmp_path / "dask") == here
    for out in ("two", "dask"):
        rows, known = _rows(tmp_path / out), _rows(tmp_path / "here")
        assert [row["recording"] for row in rows] == [row["recording"] for row in known]
        assert [row["error"] for row in rows] == [row["error"] for row in known]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--json", "x.json"], "--json does not go with --each"),
        (["--jobs", "0"], "--jobs = 0, expected 1 or more"),
    ],
)
def test_flags_that_do_not_fit_are_refused(
    folder: Path, tmp_path: Path, words: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """One line on stderr, exit 2, nothing written."""
    out = tmp_path / "out"
    line = ["diagnose", str(folder), "--each", "--drive", "bench", "--out", str(out), *words]
    assert main(line) == 2
    assert said in capsys.readouterr().err
    assert not out.exists()


def test_an_empty_folder_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The message says what is looked for."""
    empty = tmp_path / "empty"
    empty.mkdir()
    assert _run(empty, tmp_path / "out") == 2
    assert "holds no recording" in capsys.readouterr().err
