"""The gap monitor beside a drive in real time at 1 kHz: processor time, and samples missed.

The graph of `ecyl run --realtime --drive servo_1khz` with telemetry of every tick, the monitor as a
sixth process that publishes all residuals, and a listener that counts them.
"""

from __future__ import annotations

import os
import tempfile
import time
from pathlib import Path

from graph import SINE, use_private_domain
from listening import Listening
from report import Report, parser

RATE = 1000.0  # Hz, of ticks and telemetry
STATUS = "ecyl/gap_monitor gap"
COUNTED = ("samples_compared", "samples_missing", "samples_too_late", "beginnings")


def _cpu_s(pid: int) -> float:
    """Processor time a process has used, s."""
    fields = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


class Listener:
    """Counts residuals, keeps the monitor's figures and the words it used."""

    def __init__(self) -> None:
        from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
        from rclpy.qos import HistoryPolicy, QoSProfile
        from sensor_msgs.msg import JointState

        self.residuals = 0
        self.figures: dict[str, str] = {}
        self.is_there = False
        self.words: list[str] = []  # while the drive runs
        self._silent = DiagnosticStatus.STALE
        self._listening = Listening()
        everything = QoSProfile(history=HistoryPolicy.KEEP_ALL, depth=0)
        hear = self._listening.hear
        hear(JointState, "/ecyl/gap/joint_states", self._on_residual, qos=everything, raw=True)
        hear(DiagnosticArray, "/diagnostics", self._on_diagnostics, qos=100)
        self._listening.begin()

    def _on_residual(self, _: bytes) -> None:
        self.residuals += 1

    def _on_diagnostics(self, message) -> None:
        for status in message.status:
            if status.name == STATUS:
                self.is_there = True
                self.figures = {item.key: item.value for item in status.values}
                if status.level != self._silent:
                    self.words.append(status.message)

    def close(self) -> None:
        """Stop listening."""
        self._listening.close()


def run(seconds: float) -> tuple[dict, Listener]:
    """One run; the monitor's processor time and wall time while the drive ran, and who listened."""
    from ecyl_ros.drive.drive_file import load_drive, resolve_drive
    from ecyl_ros.drive.warm_up import warm_up
    from ecyl_ros.gap.live.monitor import rehearse
    from ecyl_ros.nodes.launcher import NodeProcesses, node_parameters

    path = resolve_drive("servo_1khz")
    warm_up(load_drive(path))
    rehearse(load_drive(path))
    listener = Listener()
    names = ("analyser", "reference", "controller", "plant")
    spans: list[tuple[float, float]] = []  # wall and processor time while samples come
    with tempfile.TemporaryDirectory(prefix="ecyl_bench_") as folder:
        parameters = node_parameters(
            SINE,
            Path(folder, "run.mcap"),
            Path(folder, "summary.json"),
            duration_s=seconds,
            realtime=True,
            recorder=False,
        )
        everywhere = {"telemetry_rate": RATE}
        parameters = {name: parameters[name] | everywhere for name in names}
        monitor = {"gap_monitor": {"realtime": True} | everywhere}
        with NodeProcesses(path, monitor, nodes=("gap_monitor",), realtime=True) as watching:
            pid = watching.processes["gap_monitor"].pid
            wanted = time.monotonic() + 60.0
            while not listener.is_there and time.monotonic() < wanted:
                time.sleep(0.1)

            def look() -> None:
                if listener.residuals and (not spans or time.monotonic() > spans[-1][0] + 1.0):
                    spans.append((time.monotonic(), _cpu_s(pid)))

            with NodeProcesses(path, parameters, nodes=names, realtime=True) as drive:
                drive.wait(look, True)
            time.sleep(1.2)  # for the last report
    wall, cpu = (last - first for first, last in zip(spans[0], spans[-1], strict=True))
    return {"wall_s": wall, "cpu_s": cpu, "samples": round(seconds * RATE)}, listener


def main() -> None:
    """Run it and print the figures."""
    made = parser(__doc__)
    made.add_argument("--seconds", type=float, default=60.0, help="length of the run (default 60)")
    options = made.parse_args()
    use_private_domain()
    report = Report(f"gap monitor, {options.seconds:g} s at {RATE:g} Hz")
    figures, listener = run(options.seconds)
    listener.close()
    share = figures["cpu_s"] / figures["wall_s"]
    report.target("cpu_share", share, ".3f", "0.5 or less", "share of one core")
    missed = figures["samples"] - listener.residuals
    report.target("missed", missed, "d", "0", f"residuals missed of {figures['samples']}")
    for name in COUNTED:
        report.say(f"  {name}: {listener.figures.get(name, '-')}")
    report.say(f"  last words: {listener.words[-1] if listener.words else '-'}")
    report.figures |= figures | listener.figures | {"residuals": listener.residuals}
    report.finish(options.json)


if __name__ == "__main__":
    main()
