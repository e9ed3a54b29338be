"""A node that compiles says so."""

import time

import pytest
from rclpy.node import Node

from ecyl_ros.nodes import compiling as module
from ecyl_ros.nodes.compiling import compiling


class _Logger:
    def __init__(self) -> None:
        self.lines: list[str] = []

    def info(self, line: str) -> None:
        self.lines.append(line)


class _Node(Node):
    def __init__(self) -> None:
        self.logger = _Logger()

    def get_logger(self):
        return self.logger


@pytest.mark.parametrize("slow", [True, False])
def test_a_long_start_is_explained_and_a_short_one_is_silent(monkeypatch, slow) -> None:
    """One line comes while the work is still going on, and none when it is done before."""
    monkeypatch.setattr(module, "SLOW_S", 0.01 if slow else 60.0)
    node = _Node()
    with compiling(node):
        end = time.monotonic() + 5.0
        while slow and not node.logger.lines and time.monotonic() < end:
            time.sleep(0.001)
        said = list(node.logger.lines)
    assert len(said) == (1 if slow else 0)
    assert all("compiling the drive's equations" in line for line in said)
