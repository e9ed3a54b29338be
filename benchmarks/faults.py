"""Disk full, read-only output, and jumps of the system's clock, while a graph records.

The disks are small file systems in memory, mounted for one process in a namespace of its own
(`unshare`, part of util-linux; no root needed where the kernel gives users namespaces). The wall
clock that the nodes read is moved in the middle of a run, the monotonic one left alone, as by a
time server that corrects a machine. A command passes that ends by itself, with exit code 1 or 2 and
one line that names the file, leaves no process, and what was written before opens.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from graph import SINE, use_private_domain
from report import Report, parser

PATIENCE_S = 120.0
ECYL = [sys.executable, "-m", "ecyl_ros.cli.main"]
RUN = [*ECYL, "run", "--drive", "servo_1khz", "--reference", SINE]
SIMULATE = [*ECYL, "simulate", "--drive", "bench", "--reference", SINE]
JUMPS_S = (3600.0, -3600.0, 0.5, -0.5)
# A node whose wall clock is off by what a file says.
SHIFTED = """
import sys, time
from pathlib import Path
shift, name = Path(sys.argv[1]), sys.argv[2]
real_ns, real = time.time_ns, time.time
def by(): return float(shift.read_text() or 0.0)
time.time_ns = lambda: real_ns() + round(1e9 * by())
time.time = lambda: real() + by()
from ecyl_ros.nodes.entry import run
sys.exit(run(name, sys.argv[2:]))
"""


def on_disk(
    options: str, command: list[str], folder: Path, keep: Path
) -> subprocess.CompletedProcess:
    """Run a command whose `folder` is a file system of its own; copy what it wrote to `keep`."""
    script = (
        'mount -t tmpfs -o "$1" tmpfs "$2" || exit 99; keep="$3"; folder="$2"; shift 3; '
        '"$@"; code=$?; cp "$folder"/* "$keep" 2>/dev/null; exit $code'
    )
    space = ["unshare", "--user", "--map-root-user", "--mount", "--pid", "--fork", "--kill-child"]
    return subprocess.run(
        [*space, "sh", "-c", script, "sh", options, str(folder), str(keep), *command],
        capture_output=True,
        text=True,
        timeout=PATIENCE_S,
        check=False,
    )


def disks(report: Report) -> None:
    """Every way to write a recording, on a disk that is full soon and on one that takes nothing."""
    from ecyl_ros.recording.reader import read_recording

    rows, wrong = [], 0
    for name, command in (
        ("run", [*RUN, "--duration", "600", "--out"]),
        ("run --in-process", [*RUN, "--duration", "600", "--in-process", "--out"]),
        ("simulate", [*SIMULATE, "--duration", "60", "--out"]),
    ):
        for disk, options in (("1 MB", "size=1m"), ("read-only", "ro")):
            with tempfile.TemporaryDirectory(prefix="ecyl_faults_") as base:
                folder, keep = Path(base, "disk"), Path(base, "keep")
                folder.mkdir()
                keep.mkdir()
                begin = time.monotonic()
                try:
                    done = on_disk(options, [*command, str(folder / "run.mcap")], folder, keep)
                except subprocess.TimeoutExpired:
                    rows.append([name, disk, "hangs", "", "", ""])
                    wrong += 1
                    continue
                took = time.monotonic() - begin
                if done.returncode == 99:
                    raise SystemExit("faults: no file system could be mounted (unshare)")
                opens, samples = _opens(keep / "run.mcap", read_recording)
                last = (done.stderr.strip().splitlines() or ["nothing"])[-1]
                clean = done.returncode in (1, 2) and "Traceback" not in done.stderr
                wrong += not (clean and opens and "run.mcap" in done.stderr)
                rows.append([name, disk, str(done.returncode), f"{took:.1f}", samples, last])
    report.table(["command", "disk", "exit code", "after s", "samples", "last line"], rows)
    report.target("disk_wrong", wrong, "d", "0", f"of {len(rows)} not ended as they should")


def _opens(path: Path, read) -> tuple[bool, str]:
    """Whether what there is of a recording opens, and what is in it."""
    if not path.exists():
        return True, "no file"
    try:
        return True, str(len(read(path)))
    except Exception as error:
        # Less than a chunk was written: the format has nothing whole yet.
        return path.stat().st_size < 2**18, type(error).__name__


def clocks(report: Report, seconds: float) -> None:
    """A graph in real time and one in lockstep whose clock jumps in the middle."""
    import rclpy

    if "rclpy_cyclone" not in (rclpy.__file__ or ""):
        report.say("  clock jumps left out: genuine rclpy reads the clock in C")
        return
    rows, wrong = [], 0
    for realtime in (True, False):
        for jump_s in JUMPS_S:
            length_s = seconds if realtime else 5.0 * seconds
            codes, samples, losses, expected = _jumped(realtime, jump_s, length_s)
            wrong += any(codes) or samples != expected
            cells = [f"{jump_s:+g}", "/".join(map(str, codes)), f"{samples} of {expected}", losses]
            rows.append(["real time" if realtime else "lockstep", *cells])
    report.table(["graph", "jump, s", "exit codes", "samples", "voltage losses"], rows)
    report.target("clock_wrong", wrong, "d", "0", f"of {len(rows)} with a sample missing, or ended")


def _jumped(realtime: bool, jump_s: float, length_s: float) -> tuple[list[int], int, str, int]:
    """Exit codes of plant and recorder, samples recorded, losses of voltage, samples expected."""
    from ecyl_ros.drive.drive_file import load_drive, resolve_drive
    from ecyl_ros.nodes.launcher import NODES, node_parameters, prepare_child, processors
    from ecyl_ros.recording.reader import read_recording

    path = resolve_drive("servo_1khz")
    rate = 250.0 if realtime else load_drive(path).controller.rate
    with tempfile.TemporaryDirectory(prefix="ecyl_faults_") as base:
        out, shift, summary = (Path(base, name) for name in ("run.mcap", "shift", "summary.json"))
        shift.write_text("0")
        parameters = node_parameters(
            SINE, out, summary, duration_s=length_s, realtime=realtime, rate=rate
        )
        running: dict[str, subprocess.Popen] = {}
        try:
            for name in NODES:
                command = [sys.executable, "-c", SHIFTED, str(shift), name, "--ros-args"]
                command += ["--params-file", str(path), "--log-level", "warn"]
                for key, value in parameters[name].items():
                    command += ["-p", f"{key}:={json.dumps(value)}"]
                here = processors(name)
                running[name] = subprocess.Popen(
                    command, preexec_fn=lambda here=here: prepare_child(0, here)
                )
            end = time.monotonic() + PATIENCE_S
            while not summary.exists() and time.monotonic() < end:
                time.sleep(0.02)  # written after the first second
            new = shift.with_suffix(".new")
            new.write_text(str(jump_s))
            os.replace(new, shift)
            codes = [running[name].wait(PATIENCE_S) for name in ("plant", "recorder")]
            figures = json.loads(summary.read_text(encoding="utf-8"))
            samples = len(read_recording(out))
        except subprocess.TimeoutExpired:
            return [-1], 0, "hangs", 1
        finally:
            for process in running.values():
                process.kill()
                process.wait()
    return codes, samples, str(figures.get("voltage_losses", "-")), round(length_s * 250.0)


def main() -> None:
    """Both."""
    made = parser(__doc__)
    made.add_argument("--seconds", type=float, default=6.0, help="real time, of a run (default 6)")
    options = made.parse_args()
    use_private_domain()
    report = Report("disk full, read-only output, clock jumps")
    if shutil.which("unshare"):
        disks(report)
    else:
        report.say("  disks left out: unshare is not installed (util-linux)")
    clocks(report, options.seconds)
    report.finish(options.json)


if __name__ == "__main__":
    main()
