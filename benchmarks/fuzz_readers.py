"""Every reader on files changed at random: no traceback, no hang, no memory blow-up.

Good files of each kind (MCAP, sqlite3, compressed bags, CSV, folders of tables, MAT, map, bag
metadata; drive files of every model, planned motions, joints in MJCF and URDF, diagnoses) are
changed in one to four places and read as the commands read them. A reader may give a recording or
an InputError of one line. Anything else, more than 10 s of the processor, or more than 1 GB beyond
what the process began with, is a failure; the file is kept. `--seed` and the number of the file
give it again.
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import tempfile
import threading
import time
import traceback
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
from report import ROOT, Report, parser

sys.path.insert(0, str(ROOT / "tests" / "recording"))
ROOM_BYTES = 2**30
PIECE = 500  # files per process
LONGEST_S = 300  # of the processor for them
ASLEEP_S = 3600.0  # by the clock: one that waits for ever uses no processor


def _virtual_bytes() -> int:
    for line in Path("/proc/self/status").read_text(encoding="ascii").splitlines():
        if line.startswith("VmSize:"):
            return int(line.split()[1]) * 1024
    raise SystemExit("fuzz_readers: /proc/self/status has no VmSize")


def batch(kind: str, seed: int, first: int, count: int, keep: Path, progress: Path) -> None:
    """Try files `first` up to `first + count` of one kind, in this process; prints JSON lines."""
    from fuzz_mutations import mutated
    from fuzz_seeds import seeds
    from fuzzing import tried

    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        good = seeds(folder)[kind]
        if kind == "metadata":
            (folder / kind).mkdir()
            (folder / kind / "a.mcap").write_bytes((folder / "own.mcap").read_bytes())
        for data in good:
            tried(kind, data, folder)
        room = _virtual_bytes() + ROOM_BYTES
        resource.setrlimit(resource.RLIMIT_AS, (room, room))
        # Python's own alarm cannot interrupt compiled code: the kernel ends the process.
        limit_s = LONGEST_S + int(time.process_time())
        resource.setrlimit(resource.RLIMIT_CPU, (limit_s, limit_s))
        for number in range(first, first + count):
            random = np.random.default_rng([seed, number])
            data = mutated(kind, good[int(random.integers(0, len(good)))], good, random)
            progress.write_bytes(data)
            begin = time.process_time()
            failure = ""
            try:
                came = tried(kind, data, folder)
            except BaseException as error:
                if isinstance(error, KeyboardInterrupt):
                    raise
                came = "failed"
                place = _kept(keep, kind, seed, number, data)
                last = traceback.format_exception_only(error)[-1].strip()[:200]
                frame = traceback.extract_tb(error.__traceback__)[-1]
                failure = f"{place}: {last} ({frame.filename}:{frame.lineno})"
            peak_mb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
            print(json.dumps([came, time.process_time() - begin, peak_mb, failure]), flush=True)


def _kept(keep: Path, kind: str, seed: int, number: int, data: bytes) -> Path:
    keep.mkdir(parents=True, exist_ok=True)
    place = keep / f"{kind}_{seed}_{number}"
    place.write_bytes(data)
    return place


def tries(kind: str, seed: int, first: int, count: int, keep: Path) -> list[list[Any]]:
    """`batch` in a process of its own, and again behind a file that ended or hung that process."""
    out: list[list[Any]] = []
    while len(out) < count:
        begin = first + len(out)
        with tempfile.NamedTemporaryFile() as progress:
            command = [sys.executable, __file__, "--batch", kind, str(seed), str(begin)]
            command += [str(first + count - begin), str(keep), progress.name]
            with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
                alarm = threading.Timer(ASLEEP_S, process.kill)
                alarm.start()
                assert process.stdout is not None
                lines = process.stdout.read().splitlines()
                alarm.cancel()
            found = [json.loads(line) for line in lines if line.startswith("[")]
            out += found
            if process.returncode:
                data = Path(progress.name).read_bytes()
                place = _kept(keep, kind, seed, begin + len(found), data)
                why = f"{place}: the process ended with {process.returncode}"
                out.append(["failed", 0.0, 0.0, why])
    return out


def main() -> None:
    """Share the files among processes and add up."""
    from fuzz_seeds import KINDS

    arguments = parser(__doc__)
    arguments.add_argument("--files", type=int, default=21_000, help="in all (default 21000)")
    arguments.add_argument("--seed", type=int, default=1, help="another seed, other files")
    arguments.add_argument("--kinds", nargs="+", choices=KINDS, default=KINDS, help="these alone")
    arguments.add_argument("--jobs", type=int, default=2, help="processes (default 2)")
    arguments.add_argument(
        "--keep", type=Path, default=ROOT / "out" / "fuzz", help="where failures go (out/fuzz)"
    )
    arguments.add_argument("--batch", nargs=6, help=argparse.SUPPRESS)
    options = arguments.parse_args()
    if options.batch is not None:
        kind, seed, first, count, keep, progress = options.batch
        batch(kind, int(seed), int(first), int(count), Path(keep), Path(progress))
        return
    report = Report("readers on changed files")
    each = -(-options.files // len(options.kinds))
    work = [
        (kind, options.seed, first, min(PIECE, each - first), options.keep)
        for kind in options.kinds
        for first in range(0, each, PIECE)
    ]
    with ThreadPoolExecutor(options.jobs) as pool:
        done = list(pool.map(lambda task: tries(*task), work))
    rows, failures = [], []
    for kind in options.kinds:
        own = [
            line
            for task, lines in zip(work, done, strict=True)
            if task[0] == kind
            for line in lines
        ]
        failed = [line[3] for line in own if line[0] == "failed"]
        failures += failed
        counts = [str(sum(line[0] == came for line in own)) for came in ("read", "refused")]
        slowest, peak = (f"{max(line[k] for line in own):{f}}" for k, f in ((1, ".2f"), (2, ".0f")))
        rows.append((kind, *counts, str(len(failed)), slowest, peak))
    report.table(("kind", "read", "refused", "failed", "slowest s", "peak MB"), rows)
    for line in failures[:40]:
        report.say(f"  {line}")
    report.target("files", each * len(options.kinds), "d", "20000 or more", "files")
    report.target("failures", len(failures), "d", "0", "failures")
    report.finish(options.json)


if __name__ == "__main__":
    main()
