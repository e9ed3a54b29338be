"""Replay through a graph: runs where an rclpy is installed, ROS 2's own or rclpy_cyclone."""

import contextlib
import os
import signal
import subprocess
import sys
import threading
import time

import pytest
from ecyl_ros.recording import TOPICS
from ecyl_ros.recording.bag import read_bag
from ecyl_ros.recording.timeline import Timeline
from ecyl_ros.recording.writer import write_recording
from recording_samples import made

pytest.importorskip("rclpy.node", reason="no rclpy installed", exc_type=ImportError)


@pytest.fixture
def graph(monkeypatch):
    """A graph of our own: another domain, on this machine alone."""
    import rclpy

    monkeypatch.setenv("ROS_DOMAIN_ID", str(20 + os.getpid() % 200))
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    rclpy.init()
    yield rclpy
    rclpy.try_shutdown()


def heard(rclpy, names, types):
    """A node that keeps what comes on the topics, as bytes, and the thread that spins it."""
    from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
    from rclpy.qos import QoSProfile

    node = rclpy.create_node("listener")
    got = {name: [] for name in names}
    for name, kind in zip(names, types, strict=True):
        node.create_subscription(kind, name, got[name].append, QoSProfile(depth=1000), raw=True)
    executor = SingleThreadedExecutor()
    executor.add_node(node)

    def spin():
        with contextlib.suppress(ExternalShutdownException):
            executor.spin()

    thread = threading.Thread(target=spin, daemon=True)
    thread.start()
    return got, executor, thread


def until(condition, seconds=15.0):
    """Wait for a condition; whether it came true."""
    limit = time.monotonic() + seconds
    while not condition() and time.monotonic() < limit:
        time.sleep(0.02)
    return condition()


def test_every_message_arrives_as_the_bytes_it_was(graph, tmp_path):
    """All of 4 x 300 messages reach a subscriber in order, byte for byte, one topic renamed."""
    from ecyl_ros.nodes.replayer import Replayer
    from geometry_msgs.msg import Vector3Stamped
    from sensor_msgs.msg import JointState

    write_recording(made(300), tmp_path / "bag")
    bag = read_bag(tmp_path / "bag")
    new = {"/ecyl/current": "/other/current"}
    names = [new.get(topic.name, topic.name) for topic in TOPICS]
    kinds = [JointState, JointState, Vector3Stamped, Vector3Stamped]
    got, executor, thread = heard(graph, names, kinds)
    node = Replayer(bag, Timeline(bag), remap=new)
    assert node.wait_for_subscribers(15.0)
    shares = []
    assert node.play(shares.append)
    assert node.published == 1200
    assert until(lambda: all(len(messages) == 300 for messages in got.values()))
    for topic in bag.topics.values():
        assert [bytes(m) for m in got[new.get(topic.name, topic.name)]] == topic.data
    assert shares and shares == sorted(shares) and shares[-1] <= 1.0
    executor.shutdown()
    thread.join(5.0)
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
    write_recording(made(200), tmp_path / "a.mcap")
    process = subprocess.Popen(
        [sys.executable, "-m", "ecyl_ros.cli.main", "replay", str(tmp_path / "a.mcap"), "--loop"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    node = graph.create_node("watcher")
    assert until(lambda: node.count_publishers("/ecyl/voltage") > 0)
    process.send_signal(number)
    out, err = process.communicate(timeout=20)
    assert process.returncode == 0 and "Traceback" not in err
    assert "messages published" in out
