"""SIGKILL of every node and of the recorder at random instants: what is lost, what hangs.

A lockstep graph of five processes runs without end. Again and again one of them, by turns, is
killed at a random instant and started again; a killed recorder goes on in a new file, and so does
one whose plant was killed, for that begins a new run. A hang is a graph that does not go on within
a minute. Lost is what had been published, as far as it was heard here, but does not open again from
the killed recorder's file. Then whole runs as `ecyl run` makes them, of which one node is killed,
from the first moment on: the others must end too.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from graph import SINE, use_private_domain
from listening import Listening
from report import ROOT, Report, parser

sys.path.insert(0, str(ROOT))
PROFILE = "servo_1khz"
NODES = ("recorder", "analyser", "reference", "controller", "plant")
PATIENCE_S = 60.0
LONGEST_PAUSE_S = 0.5  # from a graph that goes on to the next kill
LAUNCH_S = 12.0  # a launch is killed within so long
TO_END_S = 5.0  # a launched graph has to be gone by then
CHUNK_BYTES = 256 * 1024


class Graph:
    """The five nodes, and when each was last heard to work."""

    def __init__(self, folder: Path) -> None:
        from sensor_msgs.msg import JointState

        self._folder, self._files = folder, 0
        self.nodes: dict[str, object] = {}
        self.stamps_s: list[float] = [0.0]  # of joint states, in the order they came
        self.heard: dict[str, float] = {}  # node -> when it was last heard, monotonic s
        self._ears = Listening()
        self._ears.hear(JointState, "/ecyl/joint_states", self._on_joints)
        self._ears.hear(JointState, "/ecyl/tracking_error", lambda _: self._note("analyser"))
        self._ears.hear(JointState, "/ecyl/reference", lambda _: self._note("reference"))
        self._ears.begin()

    def _note(self, name: str) -> None:
        self.heard[name] = time.monotonic()

    def _on_joints(self, message) -> None:
        self.stamps_s.append(message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec)
        self._note("plant")
        self._note("controller")  # without its answer the plant does not go on

    @property
    def file(self) -> Path:
        """The recorder's newest."""
        return self._folder / f"{self._files}.mcap"

    def start(self, name: str) -> None:
        """Start a node, again if it was there before."""
        from tests.nodes.processes import NodeProcess

        own: list[str] = ["partner_timeout:=120.0"]
        if name == "recorder":
            self._files += 1
            own.append(f"out:={self.file}")
        if name == "reference":
            own.append(f'reference:="{SINE}"')
        self.nodes[name] = NodeProcess(name, *own, drive=PROFILE)

    def goes_on(self, since: float) -> bool:
        """Whether every node has done something after `since`."""
        size = self.file.stat().st_size if self.file.exists() else 0
        return size > 0 and all(self.heard.get(name, 0.0) > since for name in NODES[1:])

    def close(self) -> None:
        """End all."""
        for process in self.nodes.values():
            process.close()
        self._ears.close()


def _wait(condition: Callable[[], bool], seconds: float) -> float:
    """How long it took until the condition held, s; infinite if it did not."""
    begin = time.monotonic()
    while time.monotonic() < begin + seconds:
        if condition():
            return time.monotonic() - begin
        time.sleep(0.005)
    return np.inf


def restarts(report: Report, kills: int, random: np.random.Generator) -> None:
    """Kill and start again, `kills` times each node."""
    from ecyl_ros.recording.reader import read_recording

    victims = [name for name in NODES for _ in range(kills)]
    random.shuffle(victims)
    back: dict[str, list[float]] = {name: [] for name in NODES}
    lost_s: list[float] = []
    unreadable = early = 0
    with tempfile.TemporaryDirectory(prefix="ecyl_kills_") as folder:
        graph = Graph(Path(folder))
        for name in NODES:
            graph.start(name)
        try:
            if np.isinf(_wait(lambda: graph.goes_on(0.0), PATIENCE_S)):
                raise SystemExit("kills: the graph has not begun")
            for count, victim in enumerate(victims, start=1):
                time.sleep(random.uniform(0.0, LONGEST_PAUSE_S))
                others = [name for name, one in graph.nodes.items() if one.poll() is not None]
                early += len(others)
                path, heard_s = graph.file, graph.stamps_s[-1]
                graph.nodes[victim].kill()
                graph.nodes[victim].wait(PATIENCE_S)
                killed = time.monotonic()
                graph.nodes[victim].close()
                if victim == "recorder":
                    size = path.stat().st_size
                    try:
                        recording = read_recording(path)
                        lost_s.append(max(heard_s - recording.stamp_ns[-1] * 1e-9, 0.0))
                    except Exception as error:
                        if size > CHUNK_BYTES:  # else no chunk was whole yet
                            unreadable += 1
                            report.say(f"  {path.name} of {size} bytes: {error}")
                    path.unlink(missing_ok=True)
                if victim == "plant":
                    graph.nodes["recorder"].send_signal(signal.SIGINT)
                    graph.nodes["recorder"].wait(PATIENCE_S)
                    others.append("recorder")
                for name in dict.fromkeys([*others, victim]):
                    graph.start(name)
                took = _wait(lambda killed=killed: graph.goes_on(killed + 0.01), PATIENCE_S)
                back[victim].append(took)
                if np.isinf(took):
                    report.say(f"  kill {count}, of the {victim}: the graph does not go on")
                    for name, one in graph.nodes.items():
                        silent_s = time.monotonic() - graph.heard.get(name, killed)
                        report.say(f"    {name}, {silent_s:.0f} s silent: {one.said()[-300:]!r}")
                    break
                if sys.stderr.isatty():
                    print(f"\r{count} of {len(victims)} kills", end="", file=sys.stderr)
        finally:
            graph.close()
    rows = [
        [name, str(len(x)), f"{np.median(x):.2f}", f"{max(x):.2f}", str(int(np.isinf(x).sum()))]
        for name, x in back.items()
        if x
    ]
    report.table(["killed", "times", "goes on after s, median", "longest", "hangs"], rows)
    hangs = sum(int(np.isinf(x).sum()) for x in back.values())
    report.target("hangs", hangs, "d", "0", f"hangs after {sum(map(len, back.values()))} kills")
    report.target("ended_early", early, "d", "0", "nodes that ended though nobody killed them")
    report.target("unreadable", unreadable, "d", "0", "files of killed recorders that do not open")
    if lost_s:
        say = "recording lost with its recorder at most, simulated s (a chunk is 256 kB)"
        report.target("lost_s", max(lost_s), ".2f", "one chunk", say)
    report.figures |= {"back_s": back, "lost_recording_s": lost_s}


def _children(pid: int) -> list[int]:
    found: list[int] = []
    for task in Path(f"/proc/{pid}/task").glob("*/children"):
        found += [int(word) for word in task.read_text().split()]
    return found


def _name(pid: int) -> str:
    try:
        words = Path(f"/proc/{pid}/cmdline").read_text().split("\0")
    except FileNotFoundError:
        return ""
    return words[3] if len(words) > 3 else ""


def _gone(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] == "Z"
    except FileNotFoundError:
        return True


def launches(report: Report, count: int, random: np.random.Generator) -> None:
    """Whole runs, of which one node is killed."""
    from ecyl_ros.recording.reader import read_recording

    took: list[float] = []
    codes: list[int] = []
    left = read = unread = 0
    for number in range(count):
        victim = NODES[number % len(NODES)]
        with tempfile.TemporaryDirectory(prefix="ecyl_kills_") as folder:
            out = Path(folder, "run.mcap")
            command = [sys.executable, "-m", "ecyl_ros.cli.main", "run", "--drive", PROFILE]
            command += ["--reference", SINE, "--duration", "600", "--out", str(out)]
            launcher = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
            pids: dict[str, int] = {}

            def started(launcher=launcher, victim=victim, pids=pids) -> bool:
                pids.update({_name(pid): pid for pid in _children(launcher.pid)})
                return victim in pids

            _wait(started, PATIENCE_S)
            time.sleep(random.uniform(0.0, LAUNCH_S))
            everyone = _children(launcher.pid)
            os.kill(pids[victim], signal.SIGKILL)
            killed = time.monotonic()
            try:
                launcher.communicate(timeout=PATIENCE_S)
            except subprocess.TimeoutExpired:
                launcher.kill()
            codes.append(launcher.wait())
            _wait(lambda everyone=everyone: all(map(_gone, everyone)), TO_END_S)
            took.append(time.monotonic() - killed)
            left += sum(not _gone(pid) for pid in everyone)
            if out.exists() and out.stat().st_size > CHUNK_BYTES:
                try:
                    read += len(read_recording(out)) > 0
                except Exception as error:
                    unread += 1
                    report.say(f"  killed {victim}: {error}")
    report.say(f"{count} runs of `ecyl run`, one node of each killed in its first {LAUNCH_S:g} s:")
    report.target(
        "launch_ended_s", max(took), ".2f", f"{TO_END_S:g}", "the others are gone after s"
    )
    report.target("launch_left", left, "d", "0", "processes left over")
    wrong = sum(code != 1 for code in codes)
    report.target("codes", wrong, "d", "0", "launchers that ended with a code other than 1")
    report.target(
        "launch_unread", unread, "d", "0", f"recordings that do not open, of {read + unread}"
    )


def main() -> None:
    """Both parts."""
    made = parser(__doc__)
    made.add_argument("--kills", type=int, default=100, help="of each node (default 100)")
    made.add_argument("--launches", type=int, default=20, help="whole runs (default 20)")
    made.add_argument("--seed", type=int, default=1, help="of the instants (default 1)")
    options = made.parse_args()
    use_private_domain()
    report = Report(f"SIGKILL, {options.kills} times each of {len(NODES)} nodes")
    random = np.random.default_rng(options.seed)
    if options.kills:
        restarts(report, options.kills, random)
    if options.launches:
        launches(report, options.launches, random)
    report.finish(options.json)


if __name__ == "__main__":
    main()
