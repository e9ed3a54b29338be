"""Fixtures: a DDS domain per test, contexts and nodes that are cleaned up, other processes."""

import subprocess
import sys

import pytest

try:
    from rclpy_cyclone import install
except ImportError:
    pass  # genuine ROS 2 alone: what is said of rclpy here holds of it too
else:
    install()


@pytest.fixture(autouse=True)
def domain(own_domain, monkeypatch):
    """Give every test a domain of its own, and discovery as it is by default."""
    for name in ("ROS_AUTOMATIC_DISCOVERY_RANGE", "ROS_LOCALHOST_ONLY", "CYCLONEDDS_URI"):
        monkeypatch.delenv(name, raising=False)
    return own_domain


@pytest.fixture
def make_node():
    """Return a maker of nodes in contexts of their own command line."""
    from rclpy.context import Context
    from rclpy.node import Node

    made = []

    def make(name="n", args=(), context=None, **kwargs):
        if context is None:
            context = Context()
            context.init(["--ros-args", *args])
        node = Node(name, context=context, **kwargs)
        made.append(node)
        return node

    yield make
    for node in made:
        node.destroy_node()
        node.context.try_shutdown()


@pytest.fixture
def spin():
    """Return a function that spins nodes until a condition holds, or some seconds are over."""
    import time

    from rclpy.executors import SingleThreadedExecutor

    def run(condition, *nodes, seconds=30.0):
        executor = SingleThreadedExecutor(context=nodes[0].context)
        for node in nodes:
            executor.add_node(node)
        end = time.monotonic() + seconds
        while not condition() and (left := end - time.monotonic()) > 0.0:
            executor.spin_once(timeout_sec=min(left, 0.05))
        executor.shutdown()
        return condition()

    return run


@pytest.fixture
def other_process():
    """Return a starter of Python programs, which are ended after the test."""
    started = []

    def start(program, *args):
        process = subprocess.Popen(
            [sys.executable, "-c", program, *args],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        started.append(process)
        return process

    yield start
    for process in started:
        process.kill()
        process.communicate()
