"""Nodes as processes of their own, forked from one that has imported everything already.

A node's imports and compiled kernels take a second of the processor, most of what a test of three
nodes costs. What runs is the nodes' entry point with a command line, as `ros2 run` has it.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from ecyl_ros.drive.drive_file import resolve_drive

ROOT = Path(__file__).parents[2]
_CONTEXT = multiprocessing.get_context("forkserver")
_CONTEXT.set_forkserver_preload(["tests.nodes.preload"])


class NodeProcess:
    """One node; as far as tests need it, what `subprocess.Popen` is.

    Args:
        name: of the node.
        parameters: as `name:=value`.
        drive: profile or drive file.
        domain: ROS_DOMAIN_ID; this process's if not given.
        namespace: of its topics and of the node itself.
    """

    def __init__(
        self,
        name: str,
        *parameters: str,
        drive: str | Path = "bench",
        domain: int | None = None,
        namespace: str = "/",
    ) -> None:
        arguments = ["--ros-args", "--params-file", str(resolve_drive(str(drive)))]
        for parameter in parameters:
            arguments += ["-p", parameter]
        arguments += ["-r", f"__ns:={namespace}"]
        environment = dict(os.environ)
        if domain is not None:
            environment["ROS_DOMAIN_ID"] = str(domain)
        handle, log = tempfile.mkstemp(prefix=f"{name}_", suffix=".log")
        os.close(handle)
        self._log = Path(log)
        self._read = 0
        with _importing_from_here():
            self._process = _CONTEXT.Process(
                target=_run, args=(name, arguments, environment, log), daemon=True
            )
            self._process.start()
        assert self._process.pid is not None
        self.pid: int = self._process.pid

    @property
    def returncode(self) -> int | None:
        """Exit code, or less than 0 for a signal; None while it runs."""
        return self._process.exitcode

    def poll(self) -> int | None:
        """The same."""
        return self._process.exitcode

    def wait(self, timeout: float | None = None) -> int:
        """Wait for its end, s; raises TimeoutExpired with what it said."""
        self._process.join(timeout)
        code = self._process.exitcode
        if code is None:
            raise subprocess.TimeoutExpired(self._process.name, timeout or 0.0, self.said())
        return code

    def communicate(self, timeout: float | None = None) -> tuple[str, None]:
        """Wait for its end and give all it has said."""
        self.wait(timeout)
        return self._log.read_text(), None

    def said(self) -> str:
        """What it has said since this was asked last."""
        text = self._log.read_text()
        self._read, begin = len(text), self._read
        return text[begin:]

    def send_signal(self, number: int) -> None:
        """Send a signal, if it still runs."""
        if self._process.exitcode is None:
            os.kill(self.pid, number)

    def kill(self) -> None:
        """Send SIGKILL."""
        self.send_signal(signal.SIGKILL)

    def close(self) -> None:
        """End it and forget what it said."""
        self.kill()
        self._process.join()
        self._log.unlink(missing_ok=True)


@contextmanager
def _importing_from_here() -> Iterator[None]:
    """The fork server, when the first process starts it, finds what these tests import."""
    before = os.environ.get("PYTHONPATH")
    os.environ["PYTHONPATH"] = os.pathsep.join([str(ROOT), *filter(None, sys.path)])
    try:
        yield
    finally:
        if before is None:
            del os.environ["PYTHONPATH"]
        else:
            os.environ["PYTHONPATH"] = before


def _run(name: str, arguments: list[str], environment: Mapping[str, str], log: str) -> None:
    """In the new process: the node's `main`, with what it says in a file."""
    file = os.open(log, os.O_WRONLY | os.O_APPEND)
    os.dup2(file, 1)
    os.dup2(file, 2)
    os.environ.clear()
    os.environ.update(environment)
    from ecyl_ros.nodes.entry import run

    sys.exit(run(name, [name, *arguments]))
