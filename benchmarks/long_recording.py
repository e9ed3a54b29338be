"""An hour at 1 kHz: how long `ecyl inspect` and the choice of a stretch take, and in what memory.

The recording is this project's four topics with all their signals, 3.6 million samples each, as
the recorder writes them (zstd). It is written beforehand, some minutes of it at a time.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from report import Report, parser

from ecyl_ros.gap.screen import LONGEST_S
from ecyl_ros.recording import SIGNALS, TOPICS, Recording
from ecyl_ros.recording.cdr import encode
from ecyl_ros.recording.load import present
from ecyl_ros.recording.mapped import contract_map
from ecyl_ros.recording.stretch import pick_stretch
from ecyl_ros.recording.writer import RecordingWriter

RATE_HZ = 1000
PIECE = 100_000  # samples
SHORT_S = 60
START_NS = 1_700_000_000_000_000_000


def write_long(path: Path, seconds: int, *, seed: int = 1) -> None:
    """A drive that rests, but for two minutes of moves in the middle."""
    rng = np.random.default_rng(seed)
    count = seconds * RATE_HZ
    with RecordingWriter(path, overwrite=True) as writer:
        for begin in range(0, count, PIECE):
            index = np.arange(begin, min(begin + PIECE, count))
            recording = _piece(index, count, rng)
            columns = []
            for topic in TOPICS:
                joints = topic.joints
                values = {
                    field: recording.signal(signal)
                    for field, signal in topic.signals.items()
                    if not joints or field.rpartition(".")[0] in joints
                }
                columns.append(
                    encode(topic.type, topic.frame_id, joints, recording.stamp_ns, values)
                )
            for i, stamp in enumerate(recording.stamp_ns.tolist()):
                for topic, messages in zip(TOPICS, columns, strict=True):
                    writer.write(topic.name, messages[i], stamp)


def _piece(index: np.ndarray, count: int, rng: np.random.Generator) -> Recording:
    seconds = index / RATE_HZ
    middle = 0.5 * count / RATE_HZ
    lively = np.abs(seconds - middle) < 60.0
    rod = np.where(
        lively, 0.01 * np.sin(2.0 * np.pi * 0.7 * seconds), 1e-4 * np.sin(seconds / 50.0)
    )
    signals = {
        name: rod * (1.0 + 0.1 * k) + rng.normal(scale=1e-7, size=index.size)
        for k, name in enumerate(SIGNALS)
    }
    signals["reference_position_m"] = rod
    return Recording(stamp_ns=START_NS + index * (1_000_000_000 // RATE_HZ), **signals)


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


def main() -> None:
    """Write the recording, then measure."""
    arguments = parser(__doc__)
    arguments.add_argument("--seconds", type=int, default=3600, help="length (default 3600)")
    arguments.add_argument("--folder", type=Path, help="where to write it (a temporary folder)")
    options = arguments.parse_args()
    report = Report("an hour of recording at 1 kHz")
    with tempfile.TemporaryDirectory(dir=options.folder) as folder:
        short, long = Path(folder) / "short.mcap", Path(folder) / "long.mcap"
        write_long(short, SHORT_S)
        write_long(long, options.seconds)
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
        begin = time.perf_counter()
        stretch = pick_stretch(long, present(long, contract_map()), LONGEST_S)
        took_s = time.perf_counter() - begin
        report.target("stretch_s", took_s, ".1f", "as inspect", "choice of a stretch, s")
        report.say(f"  {stretch.note if stretch else 'read whole'}")
    report.finish(options.json)


if __name__ == "__main__":
    main()
