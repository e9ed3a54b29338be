"""A sweep of 100 runs on one core and on all: wall times, and that the numbers are the same.

Profile `paper`, 20 s each at 100 kHz, stiffness 50 to 150 %. Both times hold everything `ecyl
sensitivity` does after parsing: starting workers and loading compiled code included.
"""

from __future__ import annotations

import functools

from report import Report, parser, wall_time_s

from ecyl_ros.analysis.parallel import cores
from ecyl_ros.analysis.sensitivity.sweep import Experiment, Outcome, sweep
from ecyl_ros.analysis.sensitivity.vary import parse_axis, points
from ecyl_ros.drive.drive_file import load_drive
from ecyl_ros.drive.warm_up import warm_up

WANTED = {2: "0.6"}


def main() -> None:
    """Print the ratio."""
    made = parser(__doc__)
    made.add_argument("--runs", type=int, default=100, help="of the sweep (default 100)")
    made.add_argument("--duration", type=float, default=20.0, help="of a run, s (default 20)")
    options = made.parse_args()
    report = Report("sensitivity sweep")
    drive = load_drive("paper")
    warm_up(drive)
    drives = points(drive, [parse_axis(f"stiffness=0.5:1.5:{options.runs}", drive)], "paper")
    experiment = Experiment(duration_s=options.duration, skip_s=0.5 * options.duration)
    results: dict[int, list[Outcome]] = {}
    seconds: dict[int, float] = {}

    def work(jobs: int) -> None:
        results[jobs] = sweep(drives, experiment, "paper", jobs=jobs)

    for jobs in (1, cores()):
        seconds[jobs] = wall_time_s(functools.partial(work, jobs))
        report.say(f"  {options.runs} runs, {jobs} process(es): {seconds[jobs]:.1f} s")
        report.figures[f"sweep_{jobs}_s"] = seconds[jobs]
    report.say(f"  same numbers: {results[1] == results[cores()]}")
    report.target(
        "sweep_ratio",
        seconds[cores()] / seconds[1],
        ".3f",
        f"at most {WANTED.get(cores(), '0.6 on two')}",
        f"wall time on {cores()} cores over one",
    )
    report.finish(options.json)


if __name__ == "__main__":
    main()
