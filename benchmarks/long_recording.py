"""An hour at 1 kHz: how long `ecyl inspect` and `ecyl diagnose` take, and in what memory.

The recordings are this project's four topics with all their signals, 3.6 million samples each, as
the recorder writes them (zstd): the bench drive at work, moves and rests, once with cogging all
the time and once with drag on the load for ten minutes alone. They are written beforehand, a minute
of it at a time.
"""

from __future__ import annotations

import json
import math
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from long_drive import Effects, write_hour
from report import Report, parser

from ecyl_ros.recording import TOPICS

RATE_HZ = 1000
SHORT_S = 60
ALWAYS: Effects = {"cogging_torque": {"amplitude_nm": 0.05, "periods_per_rev": 24.0}}
AT_TIMES: Effects = {"load_viscous_friction": {"viscous_nm_s_per_rad": 4e-3}}
ACTING = (2.0 / 3.0, 5.0 / 6.0)  # shares of the recording between which the second fault acts


def measured(*arguments: str) -> tuple[float, float, float]:
    """Wall and processor time in s and peak memory in MB of a command, in its own process."""
    begin = time.perf_counter()
    code = (
        "import resource, sys\n"
        "from ecyl_ros.cli.main import main\n"
        "code = main(sys.argv[1:])\n"
        "used = resource.getrusage(resource.RUSAGE_SELF)\n"
        "print('used', used.ru_maxrss, used.ru_utime + used.ru_stime, file=sys.stderr)\n"
        "sys.exit(code)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, *arguments], capture_output=True, text=True, check=True
    )
    took_s = time.perf_counter() - begin
    used = next(line for line in done.stderr.splitlines() if line.startswith("used ")).split()
    return took_s, float(used[2]), int(used[1]) / 1024.0


def diagnosed(report: Report, name: str, recording: Path, hidden: Effects, about: str) -> None:
    """Diagnose a recording of the bench drive; the figures beside what is hidden in it."""
    out = recording.with_suffix(".json")
    took_s, busy_s, peak_mb = measured(
        "diagnose", str(recording), "--drive", "bench", "--json", str(out), "--overwrite"
    )
    found: dict[str, Any] = json.loads(out.read_text())
    report.say(f"  {about}: {', '.join(one['effect'] for one in found['causes']) or 'no cause'}")
    for note in found["notes"]:
        report.say(f"    {note}")
    named = {one["effect"]: one["parameters"] for one in found["causes"]}
    report.target(f"{name}_right", int(set(named) == set(hidden)), "d", "1", "    right cause")
    for effect, values in hidden.items():
        for parameter, true in values.items():
            value = named.get(effect, {}).get(parameter, {}).get("value", math.nan)
            off = 100.0 * abs(value / true - 1.0)
            key = f"{name}_{parameter}_off_percent"
            report.target(key, off, ".2f", "below 3", f"    {parameter}, % off")
    report.target(f"{name}_s", took_s, ".0f", "none", "    diagnosis, s")
    report.target(f"{name}_busy_s", busy_s, ".0f", "none", "    of these on processors, s")
    report.target(f"{name}_mb", peak_mb, ".0f", "below 1024", "    its peak, MB")


def main() -> None:
    """Write the recordings, then measure."""
    arguments = parser(__doc__)
    arguments.add_argument("--seconds", type=int, default=3600, help="length (default 3600)")
    arguments.add_argument("--folder", type=Path, help="where to write it (a temporary folder)")
    options = arguments.parse_args()
    report = Report("an hour of recording at 1 kHz")
    with tempfile.TemporaryDirectory(dir=options.folder) as folder:
        short, long = Path(folder) / "short.mcap", Path(folder) / "always.mcap"
        write_hour(short, SHORT_S, ALWAYS)
        write_hour(long, options.seconds, ALWAYS)
        size_mb = long.stat().st_size / 2**20
        report.say(f"  {options.seconds} s, {len(TOPICS)} topics, {size_mb:.0f} MB")
        measured("inspect", str(short))  # compiles what is not compiled yet
        _, _, small_mb = measured("inspect", str(short))
        out = Path(folder) / "inspection.json"
        took_s, busy_s, large_mb = measured("inspect", str(long), "--json", str(out))
        counts = {t["name"]: t["log"]["count"] for t in json.loads(out.read_text())["topics"]}
        if set(counts.values()) != {options.seconds * RATE_HZ}:
            raise SystemExit(f"long_recording: counted {counts}")
        report.target("inspect_s", took_s, ".1f", "below 10", "inspect, s")
        report.target("inspect_busy_s", busy_s, ".1f", "below 10", "of these on the processor, s")
        report.target(
            "inspect_mb", large_mb, ".0f", f"as on {SHORT_S} s: {small_mb:.0f}", "its peak, MB"
        )
        diagnosed(report, "always", long, ALWAYS, "cogging all the time")
        long.unlink()
        part = Path(folder) / "at_times.mcap"
        acting = (ACTING[0] * options.seconds, ACTING[1] * options.seconds)
        write_hour(part, options.seconds, AT_TIMES, acting, seed=2)
        diagnosed(
            report,
            "at_times",
            part,
            AT_TIMES,
            f"drag from {acting[0]:.0f} s to {acting[1]:.0f} s",
        )
    report.finish(options.json)


if __name__ == "__main__":
    main()
