"""Replay through a graph: runs where an rclpy is installed, ROS 2's own or rclpy_cyclone."""

import hashlib
import signal
import subprocess
import sys
import time

import pytest
from recording_samples import made

from ecyl_ros.recording import TOPICS
from ecyl_ros.recording.bag import read_bag
from ecyl_ros.recording.timeline import Timeline
from ecyl_ros.recording.writer import write_recording

pytest.importorskip("rclpy.node", reason="no rclpy installed", exc_type=ImportError)


@pytest.fixture
def graph(monkeypatch, own_domain):
    """A graph of our own: another domain, on this machine alone."""
    import rclpy

    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    rclpy.init()
    yield rclpy
    rclpy.try_shutdown()


ECYL = (sys.executable, "-m", "ecyl_ros.cli.main")

# Another process, as a subscriber would be. Prints a digest per topic once it has heard enough.
LISTENER = """
import hashlib, sys, time
import rclpy
from geometry_msgs.msg import Vector3Stamped
from rclpy.qos import QoSProfile
from sensor_msgs.msg import JointState

count, names = int(sys.argv[1]), sys.argv[2:]
rclpy.init()
node = rclpy.create_node("listener")
got = {name: [] for name in names}
for name, kind in zip(names, [JointState, JointState, Vector3Stamped, Vector3Stamped]):
    node.create_subscription(kind, name, got[name].append, QoSProfile(depth=1000), raw=True)
limit = time.monotonic() + 40.0
while any(len(data) < count for data in got.values()) and time.monotonic() < limit:
    rclpy.spin_once(node, timeout_sec=0.1)
for name, data in got.items():
    print(name, len(data), hashlib.sha256(b"".join(map(bytes, data))).hexdigest())
"""


def until(condition, seconds=15.0):
    """Wait for a condition; whether it came true."""
    limit = time.monotonic() + seconds
    while not condition() and time.monotonic() < limit:
        time.sleep(0.02)
    return condition()


def test_every_message_arrives_as_the_bytes_it_was(graph, tmp_path):
    """All of 4 x 300 messages reach a subscriber in order, byte for byte, one topic renamed."""
    from ecyl_ros.nodes.replayer import Replayer

    write_recording(made(300), tmp_path / "bag")
    bag = read_bag(tmp_path / "bag")
    new = {"/ecyl/current": "/other/current"}
    names = [new.get(topic.name, topic.name) for topic in TOPICS]
    listener = subprocess.Popen(
        [sys.executable, "-c", LISTENER, "300", *names],
        stdout=subprocess.PIPE,
        text=True,
        cwd=tmp_path,
    )
    node = Replayer(bag, Timeline(bag), remap=new)
    assert node.wait_for_subscribers(30.0)
    shares: list[float] = []
    assert node.play(shares.append)
    assert node.published == 1200
    heard, _ = listener.communicate(timeout=60)
    expected = [
        f"{new.get(t.name, t.name)} 300 {hashlib.sha256(b''.join(t.data)).hexdigest()}"
        for t in (bag.topics[topic.name] for topic in TOPICS)
    ]
    assert heard.splitlines() == expected
    assert shares == sorted(shares) and shares[-1] <= 1.0
    node.destroy_node()


def test_a_type_that_is_not_installed_is_refused_by_name(graph, tmp_path):
    """A topic of an unknown package: InputError with topic and type."""
    from ecyl_ros.errors import InputError
    from ecyl_ros.nodes.replayer import Replayer

    write_recording(made(5), tmp_path / "a.mcap")
    bag = read_bag(tmp_path / "a.mcap")
    bag.topics["/ecyl/current"].type = "robot_of_mine_msgs/msg/Mood"
    with pytest.raises(InputError, match=r"/ecyl/current: type robot_of_mine_msgs/msg/Mood"):
        Replayer(bag, Timeline(bag))


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_a_loop_cleanly(graph, tmp_path, number):
    """Interrupted within a loop the verb says what it sent, exits 0, and prints no traceback."""
    from geometry_msgs.msg import Vector3Stamped

    process = looping(tmp_path)
    node = graph.create_node("watcher")
    heard = []
    node.create_subscription(Vector3Stamped, "/ecyl/voltage", heard.append, 10)
    assert until(lambda: graph.spin_once(node, timeout_sec=0.02) or heard)
    process.send_signal(number)
    assert ended(process) > 0


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_while_its_topics_appear_ends_it_cleanly(graph, tmp_path, number):
    """Interrupted between its first publisher and its first message it ends in the same way."""
    process = looping(tmp_path, "--delay", "60")
    node = graph.create_node("watcher")
    assert until(lambda: node.count_publishers("/ecyl/current") > 0)
    process.send_signal(number)
    assert ended(process) == 0


def looping(folder, *options):
    """A process that replays a recording in a loop."""
    write_recording(made(200), folder / "a.mcap")
    return subprocess.Popen(
        [*ECYL, "replay", str(folder / "a.mcap"), "--loop", *options],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=folder,  # the repository's root holds a folder with the package's name
    )


def ended(process):
    """How many messages an interrupted replay says it has published, having ended as it must."""
    out, err = process.communicate(timeout=20)
    assert process.returncode == 0 and "Traceback" not in err, err
    count, _, rest = out.partition(" ")
    assert rest.startswith("messages published"), out
    return int(count)
