"""An hour in real time: the memory of every process, and the histogram of the plant's jitter.

The graph of `ecyl run --realtime` at the rate the machine holds, 1 kHz at most. What each process
holds of its own (private memory: what others share with it is not counted) is read every ten
seconds; from the first tenth of the run on, when all is loaded, a line through the readings tells
the growth per hour, with its 95 % interval, and a picture shows whether it is steady.

Cyclone DDS writes what a thread receives into a buffer of 1 MiB, from its beginning to its end: for
an hour its pages become the process's own one after the other. Here they are small, and filled at
once, so that what else grows shows.
"""

from __future__ import annotations

import json
import os
import tempfile
import time
from pathlib import Path

import numpy as np
from graph import SINE, held_rate, use_private_domain
from graph_realtime import picture
from report import ROOT, Report, parser
from scipy.stats import t as student

PROFILE = "servo_1khz"
SETTLED = 0.1  # of the run, until all is loaded
READINGS = 20  # at least
SMALL_BUFFERS = (
    "<CycloneDDS><Domain><Sizing><ReceiveBufferSize>192KiB</ReceiveBufferSize>"
    "<ReceiveBufferChunkSize>64KiB</ReceiveBufferChunkSize></Sizing></Domain></CycloneDDS>"
)


def private_bytes(pid: int) -> int:
    """What of a process's memory is its own; 0 once it is gone."""
    try:
        lines = Path(f"/proc/{pid}/smaps_rollup").read_text().splitlines()
    except OSError:
        return 0
    return 1024 * sum(int(line.split()[1]) for line in lines if line.startswith("Private_"))


def growth(seconds: np.ndarray, readings: np.ndarray) -> tuple[float, float]:
    """Slope and half its 95 % interval, per hour; neighbouring readings count as one in ten.

    Memory comes in steps, so that a reading is much like the one before.
    """
    from numpy.polynomial import Polynomial

    line = Polynomial.fit(seconds, readings, 1).convert().coef
    left = readings - (line[0] + (line[1] if len(line) > 1 else 0.0) * seconds)
    apart = max(len(seconds) / 10.0, 3.0)
    spread = np.std(seconds) * np.sqrt(apart)
    error = np.std(left) * np.sqrt(apart / (apart - 2.0)) / spread
    slope = line[1] if len(line) > 1 else 0.0
    return 3600.0 * slope, 3600.0 * error * float(student.ppf(0.975, apart - 2.0))


def run(seconds: float, rate: float, every_s: float) -> tuple[dict, dict[str, np.ndarray]]:
    """The plant's figures, and per node the readings: time s, private bytes."""
    from ecyl_ros.drive.drive_file import load_drive, resolve_drive
    from ecyl_ros.drive.warm_up import warm_up
    from ecyl_ros.nodes.launcher import NodeProcesses, node_parameters

    path = resolve_drive(PROFILE)
    warm_up(load_drive(path))
    readings: dict[str, list[tuple[float, int]]] = {}
    begin = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="ecyl_bench_") as folder:
        summary = Path(folder, "summary.json")
        parameters = node_parameters(
            SINE,
            Path(folder, "run.mcap"),
            summary,
            duration_s=seconds,
            realtime=True,
            rate=rate,
        )
        with NodeProcesses(path, parameters, realtime=True) as graph:
            last = [-np.inf]

            def read() -> None:
                now = time.monotonic() - begin
                if now < last[0] + every_s or not summary.exists():
                    return  # or it has not begun
                last[0] = now
                for name, process in graph.processes.items():
                    held = private_bytes(process.pid)
                    if held:
                        readings.setdefault(name, []).append((now, held))

            graph.wait(read, True)
        figures = json.loads(summary.read_text(encoding="utf-8"))
    return figures, {name: np.array(one, dtype=float) for name, one in readings.items()}


def memory_picture(path: Path, readings: dict[str, np.ndarray]) -> None:
    """Private memory of every node over the run, less the least that it held, as a PNG."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(7, 4), layout="constrained")
    for name, told in readings.items():
        axes.plot(told[:, 0] / 60.0, (told[:, 1] - told[:, 1].min()) / 1e6, label=name)
    axes.set(xlabel="time, min", ylabel="private memory above its least, MB")
    axes.legend()
    figure.savefig(path, dpi=120)
    plt.close(figure)


def main() -> None:
    """Measure the round trip, then run."""
    made = parser(__doc__)
    made.add_argument("--seconds", type=float, default=3600.0, help="of the run (default 3600)")
    made.add_argument("--rate", type=float, help="Hz (default: what holds, 1000 at most)")
    made.add_argument(
        "--png", type=Path, default=ROOT / "out/endurance.png", help="(default out/endurance.png)"
    )
    options = made.parse_args()
    use_private_domain()
    given = os.environ.get("CYCLONEDDS_URI")
    os.environ["CYCLONEDDS_URI"] = ",".join(filter(None, (given, SMALL_BUFFERS)))
    report = Report(f"{options.seconds:g} s in real time")
    rate, _ = held_rate(report, options.rate)
    every_s = min(10.0, options.seconds / READINGS)
    figures, readings = run(options.seconds, rate, every_s)
    report.target("met_percent", 100 * figures["met_share"], ".3f", "99.5 or more", "ticks met, %")
    jitter = {name: 1e6 * figures[f"jitter_{name}_s"] for name in ("p50", "p99", "p999", "max")}
    report.table(["jitter, us", *jitter], [["plant", *(f"{one:.0f}" for one in jitter.values())]])
    rows = []
    for name, told in readings.items():
        settled = told[told[:, 0] > told[0, 0] + SETTLED * options.seconds]
        slope, half = growth(settled[:, 0], settled[:, 1])
        mega = [value / 1e6 for value in (settled[0, 1], settled[-1, 1], slope, half)]
        rows.append([name, *(f"{value:.2f}" for value in mega)])
        report.figures[name] = dict(
            zip(("first_mb", "last_mb", "mb_per_hour", "half_95_mb"), mega, strict=True)
        )
    report.table(["private memory, MB", "settled", "at the end", "per hour", "+-"], rows)
    picture(options.png, figures, [], rate)
    report.say(f"histogram of jitter in {options.png}")
    course = options.png.with_stem(f"{options.png.stem}_memory")
    memory_picture(course, readings)
    report.say(f"memory over time in {course}")
    report.figures |= {"graph": figures}
    report.finish(options.json)


if __name__ == "__main__":
    main()
