"""Real time without a partner: the drive is brought to rest, says so, goes on or ends."""

from __future__ import annotations

import contextlib
import os
import signal
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import Vector3Stamped
from sensor_msgs.msg import JointState

from ecyl_ros.nodes import wire
from ecyl_ros.nodes.wire import to_ns
from tests.domains import domain, entered

from .conftest import UNHURRIED_HZ, Listener, unhurried
from .processes import NodeProcess

SWING = "sine:amplitude=20e-3,frequency=0.5"
NEEDED = ("controller", "reference", "plant")


class Graph:
    """Nodes in real time at a rate that any machine holds, without a launcher."""

    def __init__(self, drive: Path, number: int, partner_timeout_s: float) -> None:
        self.nodes: dict[str, NodeProcess] = {}
        self._drive, self._domain = drive, number
        self._timeout = f"partner_timeout:={partner_timeout_s}"

    def start(self, name: str) -> None:
        """Start a node, again if it was there before."""
        if name in self.nodes:
            self.nodes[name].close()
        own = [f'reference:="{SWING}"', "lookahead:=4"] if name == "reference" else []
        self.nodes[name] = NodeProcess(
            name, "realtime:=true", self._timeout, *own, drive=self._drive, domain=self._domain
        )

    def lose(self, name: str) -> None:
        """Kill a node."""
        self.nodes[name].kill()
        self.nodes[name].wait()

    def close(self) -> None:
        """End all."""
        for process in self.nodes.values():
            process.close()


@pytest.fixture(scope="module")
def own_domain() -> Iterator[int]:
    """One for the whole module, whose tests share a graph."""
    with entered() as number:
        yield number


@pytest.fixture(scope="module")
def lasting(own_domain: int, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Graph]:
    """A graph that waits a minute for a partner."""
    made = Graph(unhurried(tmp_path_factory.mktemp("watchdog")), own_domain, 60.0)
    yield made
    made.close()


@pytest.fixture
def graph(lasting: Graph, listener: Listener) -> Graph:
    """The same with all nodes at work and the rod following a sine; nothing said so far."""
    for name in NEEDED:
        if name not in lasting.nodes or lasting.nodes[name].poll() is not None:
            lasting.start(name)
        lasting.nodes[name].send_signal(signal.SIGCONT)  # should a test have failed
    assert _moves(listener)
    for process in lasting.nodes.values():
        process.said()
    return lasting


def _moves(listener: Listener) -> bool:
    return listener.until(lambda: abs(listener.rotor_rate) > 5.0, 60.0)


def _rests(listener: Listener) -> bool:
    """The rod stands still for a second."""
    still = [0, -1]

    def count() -> bool:
        if listener.joints != still[1]:
            moved = abs(listener.rotor_rate) > 1.0
            still[:] = 0 if moved else still[0] + 1, listener.joints
        return still[0] >= UNHURRIED_HZ

    return listener.until(count)


def _status(listener: Listener, name: str, level: bytes, text: str) -> bool:
    def there() -> bool:
        return listener.levels.get(name) == level and text in listener.messages[name]

    return listener.until(there, 60.0)


def test_nodes_without_a_processor_of_their_own_run_as_others(graph: Graph) -> None:
    """Started by hand, on whatever processor, no node takes real-time priority."""
    policies = [os.sched_getscheduler(process.pid) for process in graph.nodes.values()]
    usable = len(os.sched_getaffinity(0))
    assert usable == 1 or policies == [os.SCHED_OTHER] * 3


def test_without_reference_the_rod_is_held_until_it_is_back(
    graph: Graph, listener: Listener
) -> None:
    """Reference killed: the controller says so and holds the rod; started again: it moves."""
    graph.lose("reference")
    assert _status(listener, "ecyl/controller partner", DiagnosticStatus.ERROR, "position held")
    assert _rests(listener)
    assert graph.nodes["plant"].poll() is None
    graph.start("reference")
    assert _moves(listener)
    assert _status(listener, "ecyl/controller partner", DiagnosticStatus.OK, "")
    text = graph.nodes["controller"].said()
    assert "position held until it is back" in text and "is back, going on" in text


def test_without_controller_the_windings_are_shorted_until_it_is_back(
    graph: Graph, listener: Listener
) -> None:
    """Controller killed: the plant says so, the rotor comes to rest; started again: it moves."""
    graph.lose("controller")
    assert _status(listener, "ecyl/plant partner", DiagnosticStatus.ERROR, "windings shorted")
    assert _rests(listener)
    graph.start("controller")
    assert _moves(listener)
    assert _status(listener, "ecyl/plant partner", DiagnosticStatus.OK, "")
    text = graph.nodes["plant"].said()
    assert "windings shorted until it is back" in text and "is back, going on" in text


def test_telemetry_keeps_to_its_instants_whatever_is_late(graph: Graph, listener: Listener) -> None:
    """While the controller stalls again and again, no stamp of the voltage is off the samples."""
    stamps: dict[str, list[int]] = {"voltage": [], "joints": []}

    def note(key: str):
        return lambda message: stamps[key].append(to_ns(message.header.stamp))

    listener.create_subscription(Vector3Stamped, "/ecyl/voltage", note("voltage"), 1000)
    listener.create_subscription(JointState, "/ecyl/joint_states", note("joints"), 1000)
    assert listener.until(lambda: len(stamps["voltage"]) > 5)
    for _ in range(4):
        graph.nodes["controller"].send_signal(signal.SIGSTOP)
        time.sleep(3.5 / UNHURRIED_HZ)  # shorter than the watchdog's time
        graph.nodes["controller"].send_signal(signal.SIGCONT)
        listener.until(lambda: False, 0.3)
    last = stamps["joints"][-1]
    assert listener.until(lambda: stamps["joints"][-1] > last + 10**9)
    found = [stamp for stamp in stamps["voltage"] if stamps["joints"][0] <= stamp <= last]
    assert len(found) > 20 and set(found) <= set(stamps["joints"])
    assert found == sorted(set(found))


def test_a_controller_that_stands_still_is_taken_up_and_the_third_time_ends_the_run(
    graph: Graph, listener: Listener
) -> None:
    """Stopped and continued, the drive rests meanwhile and goes on; thrice in 10 s is too often."""
    graph.lose("plant")  # another one, which has lost nothing so far
    listener.until(lambda: False, 0.5)
    listener.rotor_rate = 0.0
    graph.start("plant")
    assert _moves(listener)
    for count in range(1, 4):
        graph.nodes["controller"].send_signal(signal.SIGSTOP)
        wanted = "the run ends" if count == 3 else "windings shorted"
        assert _status(listener, "ecyl/plant partner", DiagnosticStatus.ERROR, wanted)
        assert count > 1 or _rests(listener)
        graph.nodes["controller"].send_signal(signal.SIGCONT)
        if count < 3:
            assert _status(listener, "ecyl/plant partner", DiagnosticStatus.OK, "is back")
    text, _ = graph.nodes["plant"].communicate(timeout=60)
    assert graph.nodes["plant"].returncode == 1
    assert "overload: 3 times within 10 s no voltage for 0.2 s" in text
    assert f"expected a lower controller.rate than {UNHURRIED_HZ:g} Hz" in text


def test_a_lost_listener_does_not_hold_up_who_publishes(graph: Graph, listener: Listener) -> None:
    """With the analyser killed, in DDS's eyes still there, telemetry goes out without a wait.

    Published as in lockstep, it stands still until DDS misses the reader, after 10 s.
    """
    publisher = listener.create_publisher(JointState, "/ecyl/reference", wire.telemetry(True))
    listener.until(lambda: False, 0.1)
    readers = publisher.get_subscription_count()
    graph.start("analyser")
    assert listener.until(lambda: publisher.get_subscription_count() > readers)
    listener.until(lambda: False, 0.5)
    graph.lose("analyser")
    message = JointState(name=["rod"], position=[0.0] * 1000)
    took = []
    for _ in range(2000):  # more than any queue on the way holds
        begin = time.monotonic()
        publisher.publish(message)
        took.append(time.monotonic() - begin)
    assert max(took) < 5.0


FORSAKEN_S = 5.0  # their partner_timeout


@pytest.fixture(scope="module")
def forsaken(tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, Graph]]:
    """Graphs, each in a domain of its own, from which the node they are called by was killed."""
    drive = unhurried(tmp_path_factory.mktemp("forsaken"))
    with contextlib.ExitStack() as stack:
        made = {}
        for lost in NEEDED:
            made[lost] = Graph(drive, stack.enter_context(domain()), FORSAKEN_S)
            stack.callback(made[lost].close)
            for name in (*NEEDED, "analyser") if lost == "plant" else NEEDED:
                made[lost].start(name)
        log = "first measurement answered"
        for lost, one in made.items():
            end = time.monotonic() + 60.0
            while log not in one.nodes["controller"].said() and time.monotonic() < end:
                time.sleep(0.05)
            time.sleep(0.5)
            one.lose(lost)
        yield made


@pytest.mark.parametrize(
    ("lost", "left", "why"),
    [
        ("controller", "plant", "windings shorted"),
        ("reference", "controller", "position held"),
        ("reference", "plant", "windings shorted"),
        ("plant", "controller", "waiting for a plant"),
        ("plant", "reference", "waiting for a plant"),
        ("plant", "analyser", "waiting for a plant"),
    ],
)
def test_without_a_partner_for_good_a_node_ends(
    lost: str, left: str, why: str, forsaken: dict[str, Graph]
) -> None:
    """After partner_timeout it ends with a reason and exit code 1, and so do those behind it."""
    text, _ = forsaken[lost].nodes[left].communicate(timeout=60)
    assert forsaken[lost].nodes[left].returncode == 1, text
    assert why in text and "gave up waiting for" in text
