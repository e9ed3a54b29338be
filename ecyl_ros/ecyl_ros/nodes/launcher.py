"""Run the nodes as processes of their own, and end them whatever happens.

Plant, controller, reference, analyser and recorder are started, watched and stopped. None outlives
the launcher: should it be killed, the kernel asks every child to end.
"""

from __future__ import annotations

import ctypes
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

# Plant and controller come first; who only listens can wait a little when the machine is busy.
FIRST = ("plant", "controller")
REFERENCE = "reference"
LISTENING = ("analyser", "recorder")
BACKGROUND_NICE = 5
NO_SPIN = {"RCLPY_CYCLONE_SPIN_US": "0"}  # heeded by rclpy_cyclone only
NODES = ("recorder", "analyser", "reference", "controller", "plant")
END_PATIENCE_S = 15.0  # for the recorder to get the last samples after the plant is through
# For the others to end, and then for the recorder to close its file: together no more than 5 s.
# A node may be kept in a publication until DDS misses a killed listener, for 10 s.
STOP_PATIENCE_S = 2.0
CLOSE_PATIENCE_S = 2.5
POLL_S = 0.02

_PR_SET_PDEATHSIG = 1


def node_parameters(
    reference: str,
    out: Path,
    summary: Path,
    *,
    duration_s: float | None,
    realtime: bool = False,
    overwrite: bool = False,
    recorder: bool = True,
    rate: float | None = None,
) -> dict[str, dict[str, Any]]:
    """Each node's own parameters for one run of the whole graph.

    reference: SPEC. out: recording to write. summary: where the plant leaves its figures.
    duration_s: length of the run, None until stopped. recorder: whether there is one to wait for.
    rate: control rate, Hz, instead of the drive file's.
    """
    common: dict[str, Any] = {"realtime": realtime}
    if rate is not None:
        common["controller.rate"] = float(rate)
    recorded = common | ({"recorder": "recorder"} if recorder else {})
    timed = {"duration": float(duration_s)} if duration_s else {}
    return {
        "plant": recorded | timed | {"summary_file": str(summary)},
        "controller": recorded,
        "reference": recorded | timed | {"reference": reference},
        "analyser": common,
        "recorder": common | timed | {"out": str(out), "overwrite": overwrite},
    }


class GraphError(Exception):
    """A node ended before its time; the message names it."""


def processors(name: str) -> set[int]:
    """Where a node is to run: those of FIRST share a processor, the others have the rest.

    Plant and controller never work at the same time, they answer each other. On one processor
    an answer costs a switch of tasks; on two, a processor has to be woken from its sleep. The
    reference stays on one of the rest, where it may ask to run before others.
    """
    if not hasattr(os, "sched_setaffinity"):
        return set()
    usable = sorted(os.sched_getaffinity(0))
    if len(usable) < 2:
        return set(usable)
    if name in FIRST:
        return set(usable[-1:])
    return set(usable[-2:-1] if name == REFERENCE else usable[:-1])


def prepare_child(nice: int, processors: set[int]) -> None:
    """In the child: be sent SIGTERM when the parent dies (Linux; elsewhere nodes time out)."""
    os.nice(nice)
    if processors:
        os.sched_setaffinity(0, processors)
    if sys.platform.startswith("linux"):
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)


def _yaml_word(value: Any) -> str:
    """A parameter value as `-p name:=value` takes it."""
    return json.dumps(value)


class NodeProcesses:
    """The graph as processes. Use as a context manager; leaving it ends every node."""

    def __init__(
        self,
        drive_file: Path,
        parameters: Mapping[str, Mapping[str, Any]],
        *,
        log_level: str = "warn",
        nodes: Sequence[str] = NODES,
        realtime: bool = False,
        namespace: str = "",
    ) -> None:
        """parameters: node name -> its own parameters beside the drive file's.

        namespace: of all nodes and topics.
        """
        self._arguments = ["-r", f"__ns:=/{namespace.strip('/')}"] if namespace else []
        # In lockstep plant and controller wait for each other: looking out a moment before going
        # to sleep saves them wake-ups. In real time everybody has long pauses.
        self._spinning = () if realtime else FIRST
        self._drive_file = drive_file
        self._parameters = parameters
        self._log_level = log_level
        self._names = nodes
        self.processes: dict[str, subprocess.Popen] = {}

    def __enter__(self) -> NodeProcesses:
        for name in self._names:
            command = [sys.executable, "-m", "ecyl_ros.nodes.entry", name, "--ros-args"]
            command += ["--params-file", str(self._drive_file), "--log-level", self._log_level]
            command += self._arguments
            for key, value in self._parameters.get(name, {}).items():
                command += ["-p", f"{key}:={_yaml_word(value)}"]
            environment = os.environ | ({} if name in self._spinning else NO_SPIN)
            # A session of its own: Ctrl-C reaches the launcher, which ends the nodes in order.
            self.processes[name] = subprocess.Popen(
                command,
                start_new_session=True,
                preexec_fn=partial(
                    prepare_child, BACKGROUND_NICE if name in LISTENING else 0, processors(name)
                ),
                env=environment,
            )
        return self

    def ended(self) -> str | None:
        """Which node has ended, and how; None while all run."""
        for name, process in self.processes.items():
            code = process.poll()
            if code is not None:
                return f"the {name} node ended early ({_ending(code)})"
        return None

    def wait(self, progress: Callable[[], None], duration_known: bool) -> None:
        """Wait until plant and recorder are through; raises GraphError if a node ends early."""
        deadline = None
        while True:
            codes = {name: process.poll() for name, process in self.processes.items()}
            for name, code in codes.items():
                through = code == 0 and duration_known and name in ("plant", "recorder")
                if code is not None and not through:
                    raise GraphError(f"the {name} node ended early ({_ending(code)})")
            if codes.get("plant") == 0:
                if codes.get("recorder", 0) == 0:
                    return
                deadline = deadline or time.monotonic() + END_PATIENCE_S
                if time.monotonic() > deadline:
                    raise GraphError("the recorder did not get the last samples")
            progress()
            time.sleep(POLL_S)

    def __exit__(self, *_: object) -> None:
        # The plant first and the recorder last: what was sent until then is heard and kept.
        between = [name for name in self.processes if name not in ("plant", "recorder")]
        deadline = time.monotonic() + STOP_PATIENCE_S
        for names in (["plant"], between):
            self._end([self.processes[name] for name in names if name in self.processes], deadline)
        if "recorder" in self.processes:
            self._end([self.processes["recorder"]], time.monotonic() + CLOSE_PATIENCE_S)

    @staticmethod
    def _end(processes: Sequence[subprocess.Popen], deadline: float) -> None:
        alive = [process for process in processes if process.poll() is None]
        for process in alive:
            process.send_signal(signal.SIGINT)
        for process in alive:
            try:
                process.wait(max(0.1, deadline - time.monotonic()))
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()


def _ending(code: int) -> str:
    return f"signal {signal.Signals(-code).name}" if code < 0 else f"exit code {code}"
