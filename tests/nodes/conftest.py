"""Graphs of their own for every test, and what starts and hears them."""

from __future__ import annotations

import contextlib
import io
import math
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

from ecyl_ros.cli.main import main
from ecyl_ros.drive.drive_file import resolve_drive

from .processes import NodeProcess

_started: list[subprocess.Popen] = []
_nodes: list[NodeProcess] = []
SINE = "sine:amplitude=2e-3,frequency=2"


@pytest.fixture(autouse=True)
def a_domain_each(own_domain: int) -> int:
    """Every test has its own ROS_DOMAIN_ID."""
    return own_domain


@pytest.fixture(autouse=True)
def nothing_left_running() -> Iterator[None]:
    """End what a failed test left behind: a graph that runs on slows every test after it."""
    yield
    while _started:
        process = _started.pop()
        process.kill()
        process.wait()
        for pipe in (process.stdout, process.stderr):
            if pipe is not None:
                pipe.close()
    while _nodes:
        _nodes.pop().close()


def ecyl(*arguments: object, timeout: float = 120.0) -> subprocess.CompletedProcess:
    """Run `ecyl` to its end and return what it printed."""
    command = [sys.executable, "-m", "ecyl_ros.cli.main", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=timeout, check=False)


def ecyl_here(*arguments: object) -> subprocess.CompletedProcess:
    """The same within this process, which has imported everything already."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            code = main([str(argument) for argument in arguments])
        except SystemExit as end:  # argparse's way to refuse
            code = end.code
    return subprocess.CompletedProcess(arguments, code, out.getvalue(), err.getvalue())


def start(*arguments: object) -> subprocess.Popen:
    """Start `ecyl` in the background."""
    command = [sys.executable, "-m", "ecyl_ros.cli.main", *map(str, arguments)]
    pipe = subprocess.PIPE
    _started.append(subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True))
    return _started[-1]


def simulated(path: Path, *arguments: object) -> bytes:
    """Bytes of the recording that `ecyl simulate` makes with these arguments."""
    done = ecyl_here("simulate", *arguments, "--out", path)
    assert done.returncode == 0, done.stderr
    return path.read_bytes()


UNHURRIED_HZ = 25.0  # control rate that any machine holds in real time, however busy


def unhurried(folder: Path, delay_ticks: int = 1) -> Path:
    """Drive file of profile servo_1khz with gains that close its loops at `UNHURRIED_HZ`.

    Its watchdog waits five ticks, 0.2 s: longer than a busy machine keeps a process waiting.
    """
    text = resolve_drive("servo_1khz").read_text()
    for old, new in {
        "rate: 1000.0 ": f"rate: {UNHURRIED_HZ} ",
        "telemetry_rate: 250.0 ": f"telemetry_rate: {UNHURRIED_HZ} ",
        "delay_ticks: 1 ": f"delay_ticks: {delay_ticks} ",
        "position: {kp: 8.0, ki: 0.0}": "position: {kp: 5.0, ki: 0.0}",
        "speed: {kp: 0.2, ki: 0.5}": "speed: {kp: 0.023, ki: 0.0}",
        # A tick is ten times as long as the windings' time constant: they answer like a resistor.
        "current: {kp: 0.4, ki: 120.0}": "current: {kp: 0.0, ki: 7.3}",
    }.items():
        assert text.count(old) == 1
        text = text.replace(old, new)
    drive = folder / "drive.yaml"
    drive.write_text(text)
    return drive


def node(
    name: str,
    *parameters: str,
    drive: str | Path = "bench",
    domain: int | None = None,
    namespace: str = "/",
) -> NodeProcess:
    """Start one node as its own process, which ends with the test; see `NodeProcess`."""
    _nodes.append(NodeProcess(name, *parameters, drive=drive, domain=domain, namespace=namespace))
    return _nodes[-1]


class Listener(Node):
    """Keeps the newest joint states and diagnostics, and all tracking errors."""

    def __init__(self) -> None:
        super().__init__("listener")
        self.rod = math.nan
        self.rotor_rate = math.nan
        self.joints = 0  # joint states so far
        self.errors: list[float] = []
        self.statuses: dict[str, dict[str, str]] = {}
        self.messages: dict[str, str] = {}
        self.levels: dict[str, bytes] = {}
        self.setpoint = self.create_publisher(Float64, "/ecyl/setpoint", 10)
        self.create_subscription(JointState, "/ecyl/joint_states", self._on_joints, 10)
        self.create_subscription(JointState, "/ecyl/tracking_error", self._on_error, 1000)
        self.create_subscription(DiagnosticArray, "/diagnostics", self._on_diagnostics, 10)

    def _on_joints(self, message: JointState) -> None:
        self.joints += 1
        self.rod = message.position[list(message.name).index("rod")]
        self.rotor_rate = message.velocity[list(message.name).index("rotor")]

    def _on_error(self, message: JointState) -> None:
        self.errors.append(message.position[0])

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            self.statuses[status.name] = {item.key: item.value for item in status.values}
            self.messages[status.name], self.levels[status.name] = status.message, status.level


@pytest.fixture
def listener(request):
    """A listening node and a function that spins it until a condition holds."""
    rclpy.init(args=[])
    request.addfinalizer(rclpy.try_shutdown)
    node = Listener()
    executor = SingleThreadedExecutor()
    executor.add_node(node)

    def until(condition, seconds: float = 60.0) -> bool:
        deadline = time.monotonic() + seconds
        while time.monotonic() < deadline:
            executor.spin_once(timeout_sec=0.05)
            if condition():
                return True
        return False

    node.until = until
    yield node
    executor.shutdown()
    node.destroy_node()
