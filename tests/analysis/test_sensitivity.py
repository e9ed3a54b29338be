"""Sweeps against single runs, other tools' figures, and themselves on other machinery."""

import csv
import json

import pytest

from ecyl_ros.analysis import parallel
from ecyl_ros.analysis.parallel import WorkerError, over
from ecyl_ros.analysis.sensitivity.sweep import Experiment, sweep
from ecyl_ros.analysis.sensitivity.vary import parse_axis, points
from ecyl_ros.analysis.tracking import analyse
from ecyl_ros.cli.main import main
from ecyl_ros.drive.drive_file import drive_to_flat, load_drive
from ecyl_ros.drive.engine import simulate
from ecyl_ros.drive.reference.sine import Sine
from ecyl_ros.drive.telemetry import simulation_recording
from ecyl_ros.errors import InputError

SHORT = Experiment(duration_s=4.0, skip_s=1.0)
BENCH = load_drive("bench")


def bench_points(*texts: str):
    """Points of the bench drive."""
    return points(BENCH, [parse_axis(text, BENCH) for text in texts], "bench")


def test_a_point_is_what_one_run_gives():
    """A swept drive's figures are those of simulate and analyse on a drive changed by hand."""
    import dataclasses

    (outcome,) = sweep(bench_points("stiffness=0.7"), SHORT, "bench", jobs=1)
    transmission = dataclasses.replace(BENCH.transmission, stiffness=(0.7 * 6498.0,))
    drive = dataclasses.replace(BENCH, transmission=transmission)
    sine = Sine(amplitude=2e-5, frequency=1.0)
    run = simulate(drive, lambda i: sine.sample(i / drive.sample_rate), 4.0)
    expected = analyse(simulation_recording(run, drive), 1.0)
    assert outcome.figures["error_std_m"] == expected.error_std_m
    assert outcome.figures["lag_s"] == pytest.approx(expected.lag.lag_s, rel=1e-9)
    assert outcome.figures["imfs"][0]["std_m"] == expected.emd.imfs[0].std


def test_names_values_and_multiples():
    """The unique end of a key will do; = multiplies, := sets, START:STOP:COUNT spans."""
    paper = load_drive("paper")
    axis = parse_axis("stiffness=0.5,2", paper)
    assert axis.key == "transmission.stiffness" and axis.relative
    assert axis.values[1] == [2.0 * k for k in paper.transmission.stiffness]
    assert parse_axis("speed.kp=1,2", paper).key == "controller.speed.kp"
    assert parse_axis("contact_damping:=0,1e-4", paper).values == (0.0, 1e-4)
    assert parse_axis("backlash=0.5:1.5:5", paper).given == (0.5, 0.75, 1.0, 1.25, 1.5)
    assert parse_axis("feedback:=rotor,rod", paper).values == ("rotor", "rod")
    assert parse_axis("stiffness:=3;4,5;6", paper).values == ([3.0, 4.0], [5.0, 6.0])


def test_effects_are_parameters_too():
    """An effect's parameter is varied by its key, whether the drive has it yet or not."""
    (point,) = bench_points("effects.constant_load.force_n:=120")
    (outcome,) = sweep([point], SHORT, "bench", jobs=1)
    (without,) = sweep(bench_points("stiffness=1"), SHORT, "bench", jobs=1)
    assert outcome.figures["error_std_m"] != without.figures["error_std_m"]


def test_a_grid_has_every_combination():
    """Two axes: the last one fastest, all other parameters nominal."""
    grid = bench_points("stiffness=0.7,1,1.3", "backlash=0.5,1")
    assert [point.given for point in grid] == [
        (0.7, 0.5), (0.7, 1.0), (1.0, 0.5), (1.0, 1.0), (1.3, 0.5), (1.3, 1.0),
    ]  # fmt: skip
    assert dict(grid[3].flat) == drive_to_flat(BENCH)


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("stifness=1", "did you mean stiffness"),
        ("kp=1", "not unique"),
        ("stiffness", "expected NAME="),
        ("stiffness=", "no values"),
        ("stiffness=a", "expected a finite number"),
        ("stiffness=1:2:1.5", "START:STOP:COUNT"),
        ("contact_damping:=nan", "expected a finite number"),
        ("feedback=1", "is a choice"),
        ("current_limit=1", "has no multiples"),
    ],
)
def test_what_cannot_be_varied_is_refused(text, wanted):
    """Each wrong --vary is refused with what was expected."""
    with pytest.raises(InputError, match=wanted):
        parse_axis(text, load_drive("paper"))


def test_impossible_values_are_refused_before_any_run(tmp_path, capsys, monkeypatch):
    """A value beyond its range, a parameter twice, three axes: exit 2, one line, no file."""
    monkeypatch.setattr(parallel, "CONNECT_S", 0.5)
    out = tmp_path / "o.json"
    for arguments, wanted in (
        (["--vary", "load.inertia=-1"], "load.inertia = -0.001783 kg m^2"),
        (["--vary", "pole_pairs=1.1"], "whole number"),
        (["--vary", "stiffness=1", "--vary", "transmission.stiffness=2"], "varied twice"),
        (["--vary", "stiffness=1"] * 3, "given 3 times"),
        (["--vary", "stiffness=1", "--duration", "0"], "--duration"),
        (["--vary", "stiffness=1", "--skip", "99"], "--skip"),
        (["--vary", "stiffness=1", "--jobs", "0"], "--jobs"),
        (["--vary", "stiffness=1", "--reference", "triangle:x=1"], "triangle"),
        (["--vary", "stiffness=1", "--dask", "tcp://127.0.0.1:1"], "no scheduler answers"),
        (["--vary", "stiffness=1", "--dask", "nonsense://x"], "no scheduler answers"),
        (["--vary", "controller.rate:=500"], "unstable"),
    ):
        full = ["sensitivity", "--drive", "bench", *arguments, "--json", str(out)]
        assert main(full) == 2, arguments
        err = capsys.readouterr().err
        assert wanted in err and err.count("\n") == 1, (arguments, err)
        assert not out.exists()


def test_a_drive_that_cannot_run_leaves_the_others_alone(tmp_path, capsys):
    """One unstable rate in a sweep: null with the reason in JSON, an empty cell in CSV, exit 0."""
    out, table = tmp_path / "o.json", tmp_path / "o.csv"
    arguments = ["sensitivity", "--drive", "bench", "--vary", "controller.rate:=500,10000"]
    arguments += ["--duration", "3", "--json", str(out), "--csv", str(table)]
    assert main([*arguments, "--jobs", "1"]) == 0
    bad, good = json.loads(out.read_text(), parse_constant=pytest.fail)["runs"]
    assert "unstable" in bad["error"] and "error_std_m" not in bad
    assert good["error"] is None and good["error_std_m"] > 0.0
    assert "1 of 2 drives could not run" in capsys.readouterr().out
    with table.open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert rows[0]["error_std_m"] == "" and float(rows[1]["error_std_m"]) == good["error_std_m"]


def test_one_core_all_cores_and_a_cluster_give_the_same_numbers():
    """In this process, in worker processes and on a Dask cluster of two: equal to the last bit."""
    distributed = pytest.importorskip("distributed")
    drives = bench_points("stiffness=0.8,1,1.2", "backlash=0.5,1.5")
    here = sweep(drives, SHORT, "bench", jobs=1)
    assert len({one.figures["error_std_m"] for one in here}) == len(drives)
    assert sweep(drives, SHORT, "bench", jobs=2) == here
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None
    ) as cluster:
        shares: list[float] = []
        address = cluster.scheduler_address
        assert sweep(drives, SHORT, "bench", dask=address, progress=shares.append) == here
    assert shares == pytest.approx([(i + 1) / len(drives) for i in range(len(drives))])


def test_the_verb_runs_on_a_cluster(tmp_path):
    """--dask ADDRESS writes the JSON that --jobs 1 writes, byte for byte."""
    distributed = pytest.importorskip("distributed")
    command = ["sensitivity", "--drive", "bench", "--vary", "stiffness=0.9,1.1", "--duration", "2"]
    with distributed.LocalCluster(n_workers=1, dashboard_address=None) as cluster:
        address = cluster.scheduler_address
        assert main([*command, "--dask", address, "--json", str(tmp_path / "a.json")]) == 0
    assert main([*command, "--jobs", "1", "--json", str(tmp_path / "b.json")]) == 0
    assert (tmp_path / "a.json").read_bytes() == (tmp_path / "b.json").read_bytes()


def _dies(argument: int) -> int:
    import os
    import signal

    if argument == 2:
        os.kill(os.getpid(), signal.SIGKILL)
    return argument


def test_a_worker_that_dies_is_told_in_one_line():
    """A killed worker process ends the sweep with a message, not a traceback."""
    with pytest.raises(WorkerError, match="died after"):
        over(_dies, [0, 1, 2, 3], jobs=2)


def test_table_3_in_the_published_reading(tmp_path, capsys):
    """`--vary stiffness=0.7,...,1.3` on profile `paper`: within 2 % of what LSODA and Radau gave,
    undamped, and the curve over one parameter is drawn."""
    out = tmp_path / "o.json"
    command = ["sensitivity", "--drive", "paper", "--vary", "stiffness=0.7,0.9,1,1.1,1.3"]
    assert main([*command, "--json", str(out), "--plots", str(tmp_path)]) == 0
    result = json.loads(out.read_text(), parse_constant=pytest.fail)
    spreads = [run["error_std_m"] * 1e3 for run in result["runs"]]
    assert spreads == pytest.approx([0.0068, 0.0062, 0.0060, 0.0059, 0.0056], rel=0.02)
    assert result["schema"] == "ecyl.sensitivity/1"
    assert result["vary"][0]["given"] == [0.7, 0.9, 1.0, 1.1, 1.3]
    for run in result["runs"]:
        assert 2.5 < run["imfs"][0]["frequency_hz"] < 3.6
        assert run["imfs"][1]["frequency_hz"] == pytest.approx(1.0, abs=0.01)
    assert (tmp_path / "sensitivity.png").stat().st_size > 10_000
    assert "of nominal" in capsys.readouterr().out


def test_two_parameters_are_drawn_as_maps(tmp_path):
    """A grid writes a picture as well."""
    command = ["sensitivity", "--drive", "bench", "--duration", "2", "--plots", str(tmp_path)]
    assert main([*command, "--vary", "stiffness=0.8,1", "--vary", "feedback:=rotor,rod"]) == 0
    assert (tmp_path / "sensitivity.png").stat().st_size > 10_000
