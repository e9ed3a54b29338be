"""Overload made on purpose and taken away: a busy process per core beside the graph in real time.

Calm, overload, calm, as long each. The plant's counts on /diagnostics, once a second, give the
ticks met in every second; back is the drive from the second on since when 99 % of all ticks were
met to the end. Runs at the rate that the machine holds when it is calm, 1 kHz at most.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from graph import SINE, held_rate, use_private_domain
from listening import Listening
from report import Report, parser

PROFILE = "servo_1khz"
STATUS = "ecyl/plant timing"
ENOUGH = 0.99
COUNTS = ("ticks", "missed_ticks", "late_ticks", "stale_ticks", "voltage_losses")


class Ears:
    """The plant's counts as they come, and how far the rod is from its reference."""

    def __init__(self) -> None:
        from diagnostic_msgs.msg import DiagnosticArray
        from sensor_msgs.msg import JointState

        self.counts: list[tuple[float, dict[str, int]]] = []  # monotonic s, counts so far
        self.errors: list[tuple[float, float]] = []  # monotonic s, tracking error m
        self._ears = Listening()
        self._ears.hear(DiagnosticArray, "/diagnostics", self._on_diagnostics)
        self._ears.hear(JointState, "/ecyl/tracking_error", self._on_error)
        self._ears.begin()
        self.close = self._ears.close

    def _on_diagnostics(self, message) -> None:
        for status in message.status:
            if status.name == STATUS:
                values = {item.key: item.value for item in status.values}
                told = {key: round(float(values[key])) for key in COUNTS}
                self.counts.append((time.monotonic(), told))

    def _on_error(self, message) -> None:
        self.errors.append((time.monotonic(), message.position[0]))

    def met(self) -> list[tuple[float, float]]:
        """For every report but the first: its time, and the share of ticks met since the last."""
        out = []
        for (_, before), (at, now) in zip(self.counts, self.counts[1:], strict=False):
            ticks = max(now["ticks"] - before["ticks"], 1)
            out.append((at, 1.0 - (now["missed_ticks"] - before["missed_ticks"]) / ticks))
        return out


def run(report: Report, seconds: float, rate: float, per_core: int) -> None:
    """The three parts, and what became of the graph."""
    from ecyl_ros.drive.drive_file import load_drive, resolve_drive
    from ecyl_ros.drive.warm_up import warm_up
    from ecyl_ros.nodes.launcher import NodeProcesses, node_parameters

    path = resolve_drive(PROFILE)
    warm_up(load_drive(path))
    ears = Ears()
    marks: list[float] = []
    busy: list[subprocess.Popen] = []
    with tempfile.TemporaryDirectory(prefix="ecyl_bench_") as folder:
        parameters = node_parameters(
            SINE,
            Path(folder, "run.mcap"),
            Path(folder, "summary.json"),
            duration_s=3.0 * seconds,
            realtime=True,
            rate=rate,
        )

        def steps() -> None:
            """Make the load, and take it away, when it is time."""
            now = time.monotonic()
            if not marks and ears.counts:
                marks.append(now)
            elif len(marks) == 1 and now > marks[0] + seconds:
                command = [sys.executable, "-c", "while True: pass"]
                busy.extend(
                    subprocess.Popen(command) for _ in range(per_core * (os.cpu_count() or 1))
                )
                marks.append(now)
            elif len(marks) == 2 and now > marks[1] + seconds:
                for process in busy:
                    process.kill()
                    process.wait()
                marks.append(time.monotonic())

        ended = "to its end, with the processes it began with"
        try:
            with NodeProcesses(path, parameters, realtime=True) as graph:
                graph.wait(steps, True)
        except Exception as error:
            ended = f"no: {error}"
        finally:
            for process in busy:
                process.kill()
                process.wait()
            ears.close()
    report.say(f"  ran: {ended}")
    shown(report, ears, marks)


def shown(report: Report, ears: Ears, marks: list[float]) -> None:
    """Ticks met in each part, the way back, and the tracking error before and after."""
    met = ears.met()
    edges = [*marks, np.inf]
    names = ("calm", "overload", "calm again")
    rows = []
    for name, begin, end in zip(names, edges, edges[1:], strict=False):
        inside = [share for at, share in met if begin < at <= end]
        errors = [error for at, error in ears.errors if begin < at <= end]
        if not inside or not errors:
            continue
        rms_um = 1e6 * float(np.sqrt(np.mean(np.square(errors))))
        cells = [100 * float(np.mean(inside)), 100 * min(inside), rms_um]
        rows.append([name, *(f"{cell:.2f}" for cell in cells)])
        report.figures[name.replace(" ", "_")] = dict(
            zip(("met_percent", "worst_second_percent", "error_rms_um"), cells, strict=True)
        )
    report.table(["", "ticks met, %", "worst second, %", "tracking error rms, um"], rows)
    if len(marks) < 3:
        report.say("  the load was not taken away: the graph ended before")
        return
    after = [(at, share) for at, share in met if at > marks[2]]
    back_s = np.inf
    for index, (at, _) in enumerate(after):
        if np.mean([share for _, share in after[index:]]) >= ENOUGH and after[index][1] >= ENOUGH:
            before = after[index - 1][0] if index else marks[2]
            back_s = max(before, marks[2]) - marks[2] if at > marks[2] else 0.0
            break
    report.target("back_s", back_s, ".1f", "2 or less", "back to 99 % of ticks met after s")
    losses = ears.counts[-1][1]["voltage_losses"]
    report.target("voltage_losses", losses, "d", "0", "times the windings were shorted")


def main() -> None:
    """Measure the round trip, then run."""
    made = parser(__doc__)
    made.add_argument("--seconds", type=float, default=60.0, help="of each part (default 60)")
    made.add_argument("--per-core", type=int, default=1, help="busy processes (default 1)")
    made.add_argument("--rate", type=float, help="Hz (default: what holds, 1000 at most)")
    options = made.parse_args()
    use_private_domain()
    report = Report(f"overload and release, {options.seconds:g} s each")
    rate, _ = held_rate(report, options.rate)
    run(report, options.seconds, rate, options.per_core)
    report.finish(options.json)


if __name__ == "__main__":
    main()
