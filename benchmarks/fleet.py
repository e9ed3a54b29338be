"""A folder of recordings on one core, on all, and on Dask workers: times as ratios, same numbers.

    python benchmarks/fleet.py --recordings 100

Recordings of a bench drive are made by the engine, healthy ones and ones with friction. One core is
one process that may use one core alone; the runs take turns, so that what else the machine does
falls on all.
"""

from __future__ import annotations

import dataclasses
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from report import Report, parser

from ecyl_ros.drive.drive_file import load_drive, resolve_drive
from ecyl_ros.drive.engine import simulate
from ecyl_ros.drive.reference.moves import Moves
from ecyl_ros.drive.telemetry import simulation_recording
from ecyl_ros.recording.writer import write_recording

MOVES = Moves((0.004, -0.002, 0.001), speed=0.05, acceleration=1.0, jerk=50.0)
LENGTH_S = 2.0
FAULTY = 5  # one recording in so many has a fault: most of a fleet is healthy
ECYL = Path(sys.executable).with_name("ecyl")


def main() -> int:
    options_of = parser(__doc__.split("\n")[0])
    options_of.add_argument("--recordings", type=int, default=100)
    options_of.add_argument("--dask", action="store_true", help="run on two Dask workers, too")
    options = options_of.parse_args()
    report = Report("A folder of recordings")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        _record(folder / "fleet", options.recordings)
        seconds = {"one core": _run(folder, "one", ["--jobs", "1"], cores={0})}
        seconds["all cores"] = _run(folder, "all", [])
        same = _numbers(folder / "one") == _numbers(folder / "all")
        if options.dask:
            seconds["two Dask workers"] = _on_dask(folder)
            same = same and _numbers(folder / "one") == _numbers(folder / "dask")
        rows = [
            [name, f"{value:.1f} s", f"{value / seconds['one core']:.2f}"]
            for name, value in seconds.items()
        ]
        report.table(["run on", "time", "over one core's"], rows)
        report.say(f"the same numbers from all: {'yes' if same else 'no'}")
        report.figures["seconds"] = seconds
        report.figures["same"] = same
        if options.json is not None:
            options.json.write_text(json.dumps(report.figures, indent=2) + "\n")
    return 0 if same else 1


def _record(folder: Path, count: int) -> None:
    drive = load_drive(resolve_drive("bench"))
    rate = drive.sample_rate
    for number in range(count):
        sensors = dataclasses.replace(drive.sensors, noise_seed=number + 1)
        friction = {"rotor_coulomb_friction": {"coulomb_nm": 0.02 + 1e-3 * number}}
        effects = friction if number % FAULTY == 0 else {}
        one = dataclasses.replace(drive, sensors=sensors, effects=effects)
        run = simulate(one, lambda index: MOVES.sample(index / rate), LENGTH_S)
        write_recording(simulation_recording(run, one), folder / f"press_{number:03d}.mcap")


def _run(folder: Path, name: str, words: list[str], cores: set[int] | None = None) -> float:
    line = [ECYL, "diagnose", folder / "fleet", "--each", "--drive", "bench"]
    line += ["--out", folder / name, *words]
    begin = time.perf_counter()
    subprocess.run(
        [str(word) for word in line],
        check=True,
        stdout=subprocess.DEVNULL,
        preexec_fn=None if cores is None else lambda: os.sched_setaffinity(0, cores),
    )
    return time.perf_counter() - begin


def _on_dask(folder: Path) -> float:
    import dask
    from distributed import LocalCluster

    # Workers look at their own stacks a hundred times a second unless told not to.
    quiet = dask.config.set({"distributed.worker.profile.enabled": False})
    one_each = {"n_workers": 2, "threads_per_worker": 1, "dashboard_address": None}
    with quiet, LocalCluster(**one_each) as cluster:
        return _run(folder, "dask", ["--dask", cluster.scheduler_address])


def _numbers(out: Path) -> dict[str, object]:
    found: dict[str, object] = {}
    for path in sorted((out / "recordings").glob("*.json")):
        data = json.loads(path.read_text())
        data.pop("seconds")
        found[path.name] = data
    return found


if __name__ == "__main__":
    assert shutil.which(str(ECYL)), ECYL
    sys.exit(main())
