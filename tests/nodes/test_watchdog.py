"""Real time without a partner: the drive is brought to rest, says so, goes on or ends."""

from __future__ import annotations

import os
import signal
import subprocess
from collections.abc import Iterator

import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import Vector3Stamped
from sensor_msgs.msg import JointState

from ecyl_ros.drive.drive_file import load_drive
from ecyl_ros.drive.warm_up import warm_up
from ecyl_ros.nodes.wire import to_ns

from .conftest import SINE, Listener, node

TIMEOUT_S = 6.0  # partner_timeout of all nodes: more than a node takes to start again


class Graph:
    """Plant, controller and reference of profile servo_1khz in real time, without a launcher."""

    def __init__(self) -> None:
        self.nodes: dict[str, subprocess.Popen] = {}

    def start(self, name: str, *parameters: str) -> None:
        """Start a node, again if it was there before."""
        self.nodes[name] = node(
            name,
            "realtime:=true",
            f"partner_timeout:={TIMEOUT_S}",
            *parameters,
            drive="servo_1khz",
        )

    def lose(self, name: str) -> None:
        """Kill a node."""
        self.nodes[name].kill()
        self.nodes[name].communicate()

    def end(self, name: str) -> str:
        """Interrupt a node and return what it logged."""
        self.nodes[name].send_signal(signal.SIGINT)
        return self.nodes[name].communicate(timeout=20)[0]


@pytest.fixture
def graph(listener: Listener) -> Iterator[Graph]:
    """A graph in which the rod follows a sine."""
    made = Graph()
    warm_up(load_drive("servo_1khz"))  # compiled once, not by each node
    try:
        made.start("controller")
        made.start("reference", f'reference:="{SINE}"', "lookahead:=16")
        made.start("plant")
        assert listener.until(lambda: abs(listener.rotor_rate) > 5.0, 60.0)
        yield made
    finally:
        for process in made.nodes.values():
            process.kill()
            process.wait()


def _moves(listener: Listener) -> bool:
    return listener.until(lambda: abs(listener.rotor_rate) > 5.0)


def _rests(listener: Listener) -> bool:
    """The rod stands still for 100 joint states."""
    still = [0, -1]

    def count() -> bool:
        if listener.joints != still[1]:
            moved = abs(listener.rotor_rate) > 0.1
            still[:] = 0 if moved else still[0] + 1, listener.joints
        return still[0] >= 100

    return listener.until(count)


def _status(listener: Listener, name: str, level: bytes, text: str) -> bool:
    def there() -> bool:
        return listener.levels.get(name) == level and text in listener.messages[name]

    return listener.until(there)


def test_without_controller_the_windings_are_shorted_until_it_is_back(graph, listener) -> None:
    """Controller killed: the plant says so, the rotor comes to rest; started again: it moves."""
    graph.lose("controller")
    assert _status(listener, "ecyl/plant partner", DiagnosticStatus.ERROR, "windings shorted")
    assert _rests(listener)
    graph.start("controller")
    assert _moves(listener)
    assert _status(listener, "ecyl/plant partner", DiagnosticStatus.OK, "")
    text = graph.end("plant")
    assert "windings shorted until it is back" in text and "is back, going on" in text


def test_without_controller_for_good_the_plant_ends(graph, listener) -> None:
    """After partner_timeout the plant ends with a reason and exit code 1."""
    graph.lose("controller")
    text, _ = graph.nodes["plant"].communicate(timeout=60)
    assert graph.nodes["plant"].returncode == 1
    assert "windings shorted" in text and "gave up waiting for" in text


def test_a_controller_that_stands_still_is_noticed_and_taken_up_again(graph, listener) -> None:
    """Controller stopped and continued: the drive rests meanwhile and goes on after."""
    graph.nodes["controller"].send_signal(signal.SIGSTOP)
    try:
        assert _status(listener, "ecyl/plant partner", DiagnosticStatus.ERROR, "windings shorted")
        assert _rests(listener)
    finally:
        graph.nodes["controller"].send_signal(signal.SIGCONT)
    assert _moves(listener)
    assert _status(listener, "ecyl/plant partner", DiagnosticStatus.OK, "")


def test_without_reference_the_rod_is_held_until_it_is_back(graph, listener) -> None:
    """Reference killed: the controller says so and holds the rod; started again: it moves."""
    graph.lose("reference")
    assert _status(listener, "ecyl/controller partner", DiagnosticStatus.ERROR, "position held")
    assert _rests(listener)
    assert graph.nodes["plant"].poll() is None
    graph.start("reference", f'reference:="{SINE}"', "lookahead:=16")
    assert _moves(listener)
    assert _status(listener, "ecyl/controller partner", DiagnosticStatus.OK, "")
    text = graph.end("controller")
    assert "position held until it is back" in text and "is back, going on" in text


def test_without_reference_for_good_controller_and_plant_end(graph, listener) -> None:
    """After partner_timeout the controller ends with a reason, and so then does the plant."""
    graph.lose("reference")
    for name, why in (("controller", "position held"), ("plant", "windings shorted")):
        text, _ = graph.nodes[name].communicate(timeout=60)
        assert graph.nodes[name].returncode == 1
        assert why in text and "gave up waiting for" in text


def test_a_lost_listener_does_not_hold_up_the_drive(graph, listener) -> None:
    """Analyser killed: for as long as DDS misses it, the plant loses no voltage."""
    graph.start("analyser")
    assert listener.until(lambda: len(listener.errors) > 100)
    graph.lose("analyser")
    heard = listener.joints
    assert listener.until(lambda: listener.joints > heard + 3000)
    text = graph.end("plant")
    assert "windings shorted" not in text


def test_nodes_without_a_processor_of_their_own_run_as_others(graph, listener) -> None:
    """Started by hand, on whatever processor, no node takes real-time priority."""
    policies = [os.sched_getscheduler(process.pid) for process in graph.nodes.values()]
    usable = len(os.sched_getaffinity(0))
    assert usable == 1 or policies == [os.SCHED_OTHER] * 3


def test_without_plant_the_others_end(graph, listener) -> None:
    """Plant killed: controller, reference and analyser say so and end with a reason."""
    graph.start("analyser")
    assert listener.until(lambda: len(listener.errors) > 100)
    graph.lose("plant")
    for name in ("controller", "reference", "analyser"):
        text, _ = graph.nodes[name].communicate(timeout=60)
        assert graph.nodes[name].returncode == 1, (name, text)
        assert "waiting for a plant" in text and "gave up waiting for a plant" in text


def test_a_voltage_lost_again_and_again_ends_the_run(graph, listener) -> None:
    """Three losses within ten seconds: the plant ends with the reason and exit code 1."""
    lost = "windings shorted"
    for count in range(1, 4):
        graph.nodes["controller"].send_signal(signal.SIGSTOP)
        wanted = "the run ends" if count == 3 else lost
        assert _status(listener, "ecyl/plant partner", DiagnosticStatus.ERROR, wanted)
        graph.nodes["controller"].send_signal(signal.SIGCONT)
        if count < 3:
            assert _status(listener, "ecyl/plant partner", DiagnosticStatus.OK, "is back")
    text, _ = graph.nodes["plant"].communicate(timeout=20)
    assert graph.nodes["plant"].returncode == 1
    assert "overload: 3 times within 10 s no voltage for 0.1 s" in text
    assert "expected a lower controller.rate than 1000 Hz" in text


def test_telemetry_keeps_to_its_instants_whatever_is_late(graph, listener) -> None:
    """While the controller stalls again and again, no stamp of the voltage is off the samples."""
    stamps: dict[str, list[int]] = {"voltage": [], "joints": []}

    def note(key: str):
        return lambda message: stamps[key].append(to_ns(message.header.stamp))

    listener.create_subscription(Vector3Stamped, "/ecyl/voltage", note("voltage"), 1000)
    listener.create_subscription(JointState, "/ecyl/joint_states", note("joints"), 1000)
    assert listener.until(lambda: len(stamps["voltage"]) > 50)
    for _ in range(10):  # shorter than the watchdog's time
        graph.nodes["controller"].send_signal(signal.SIGSTOP)
        listener.until(lambda: False, 0.03)
        graph.nodes["controller"].send_signal(signal.SIGCONT)
        listener.until(lambda: False, 0.1)
    graph.end("controller")
    listener.until(lambda: False, 0.3)
    found = [stamp for stamp in stamps["voltage"] if stamp >= stamps["joints"][0]]
    assert len(found) > 200 and set(found) <= set(stamps["joints"])
    assert found == sorted(set(found))
