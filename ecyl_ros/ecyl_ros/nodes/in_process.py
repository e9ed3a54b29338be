"""Run all nodes in one process, on one executor."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import rclpy
from rclpy.executors import Executor, ExternalShutdownException
from rclpy.parameter import Parameter

from .analyser import Analyser
from .controller import Controller
from .direct_executor import make_executor
from .drive_node import DriveNode
from .launcher import GraphError
from .plant import Plant
from .quiet_signals import quiet_signals
from .recorder import Recorder
from .reference import ReferenceGenerator

CLASSES: dict[str, Callable[..., DriveNode]] = {
    "recorder": Recorder,
    "analyser": Analyser,
    "reference": ReferenceGenerator,
    "controller": Controller,
    "plant": Plant,
}
PROGRESS_S = 0.1


def run_in_process(
    drive_file: Path,
    parameters: Mapping[str, Mapping[str, Any]],
    progress: Callable[[], None],
    *,
    log_level: str = "warn",
    names: tuple[str, ...] = tuple(CLASSES),
) -> None:
    """Run the graph until the plant and, if there is one, the recorder are through.

    Raises KeyboardInterrupt if it was interrupted (the recording is closed first), GraphError if a
    node ended for a reason of its own.
    """
    with quiet_signals():
        _run(drive_file, parameters, progress, log_level, names)


def _run(
    drive_file: Path,
    parameters: Mapping[str, Mapping[str, Any]],
    progress: Callable[[], None],
    log_level: str,
    names: tuple[str, ...],
) -> None:
    arguments = ["--ros-args", "--params-file", str(drive_file), "--log-level", log_level]
    nodes: dict[str, DriveNode] = {}
    rclpy.init(args=["ecyl", "--ros-args", "--log-level", log_level])
    try:
        for name in names:
            overrides = [
                Parameter(key, value=value) for key, value in parameters.get(name, {}).items()
            ]
            nodes[name] = CLASSES[name](cli_args=arguments, parameter_overrides=overrides)
        executor = make_executor(*nodes.values())
        nodes["plant"].create_timer(PROGRESS_S, progress)
        for name in ("plant", "recorder"):
            if name in nodes:
                _spin(executor, nodes, name)
    except ExternalShutdownException:
        raise KeyboardInterrupt from None
    except Exception:
        if rclpy.ok():
            raise
        # A signal has shut the context down while a callback ran; what it publishes then fails.
        raise KeyboardInterrupt from None
    finally:
        with contextlib.ExitStack() as ending:  # all of it, whatever of it fails
            ending.callback(rclpy.try_shutdown)
            for node in reversed(nodes.values()):
                ending.callback(node.destroy_node)
                ending.callback(node.close)


def _spin(executor: Executor, nodes: Mapping[str, DriveNode], name: str) -> None:
    executor.spin_until_future_complete(nodes[name].done)
    for other, node in nodes.items():
        if node.done.done() and node.done.result()[0]:
            raise GraphError(f"the {other} node ended early: {node.done.result()[1]}")
    if not nodes[name].done.done():
        raise KeyboardInterrupt
