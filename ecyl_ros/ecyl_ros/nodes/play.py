"""One task on a drive, in a ROS context of its own; and an emulated drive to play it on."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import rclpy
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from ..errors import InputError
from ..investigate.played import Played, Seen
from .direct_executor import make_executor
from .launcher import NodeProcesses
from .player import Player, Task

NAME = "investigator"
NODES = ("reference", "controller", "plant")


def play(
    task: Task, *, namespace: str = "", alive: Callable[[], str | None] = lambda: None
) -> Seen | Played:
    """Play it to its end, or until it is broken off: by the bounds, or by SIGINT and SIGTERM.

    alive: see `Player`.

    Raises:
        InputError: no drive, or one that is not at rest or does not follow; nothing has moved.
        KeyboardInterrupt: SIGINT or SIGTERM came before anything moved.
    """
    rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
    try:
        node = Node(NAME, namespace=namespace or None, start_parameter_services=False)
        player = Player(node, task, alive)
        executor = make_executor(node)
        told: list[str] = []

        def stop(name: str) -> None:
            told.append(name)
            player.end(f"stopped by {name}")

        with _signals(stop):
            executor.spin_until_future_complete(player.done)
        result: Seen | Played | InputError = player.done.result()
        node.destroy_node()
    finally:
        rclpy.try_shutdown()
    if isinstance(result, InputError):
        if told:
            raise KeyboardInterrupt
        raise result
    return result


@contextmanager
def _signals(tell: Callable[[str], None]) -> Iterator[None]:
    """Within, SIGINT and SIGTERM are told instead of raised: the drive has to be stopped first."""
    told = {signal.SIGINT: "Ctrl-C", signal.SIGTERM: "SIGTERM"}
    before = {
        number: signal.signal(number, lambda *_, name=name: tell(name))
        for number, name in told.items()
    }
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


@contextmanager
def emulated(
    drive_file: Path, namespace: str, *, realtime: bool = False
) -> Iterator[Callable[[], str | None]]:
    """The nodes of a drive that follows setpoints and trajectories; yields `alive` for `play`."""
    parameters: dict[str, dict[str, Any]] = {name: {"realtime": realtime} for name in NODES}
    parameters["reference"]["reference"] = "setpoint"
    with NodeProcesses(
        drive_file,
        parameters,
        nodes=NODES,
        realtime=realtime,
        log_level="error",
        namespace=namespace,
    ) as processes:
        yield processes.ended
