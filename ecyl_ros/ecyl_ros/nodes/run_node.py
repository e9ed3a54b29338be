"""The common `main` of all nodes: init, spin until done, shut down, exit code."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Sequence

import rclpy
from rclpy.executors import Executor, ExternalShutdownException

from ..errors import InputError
from .direct_executor import DirectExecutor, make_executor
from .drive_node import DriveNode
from .quiet_signals import quiet_signals


def run_node(make: Callable[[], DriveNode], args: Sequence[str] | None = None) -> int:
    """Run one node until it is done or interrupted and return the process's exit code.

    0: done or interrupted by a signal. 1: it ended for a reason of its own, such as a lost
    partner. 2: unusable input, said in one line.
    """
    with quiet_signals():
        return _run(make, args)


def _run(make: Callable[[], DriveNode], args: Sequence[str] | None) -> int:
    node: DriveNode | None = None
    said = ""
    rclpy.init(args=None if args is None else list(args))
    try:
        node = make()
        executor = make_executor(node)
        if node.batch_s and not isinstance(executor, DirectExecutor):
            _spin_in_batches(executor, node)
        else:
            executor.spin_until_future_complete(node.done)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    except InputError as error:
        said = _say(error)
    except Exception:
        if rclpy.ok():
            raise
        # A signal has shut the context down while a callback ran; what it publishes then fails.
    finally:
        if node is not None:
            try:
                node.close()
            except InputError as error:  # of a disk that is full perhaps once more
                said = said or _say(error)
            node.destroy_node()
        rclpy.try_shutdown()
    if said:
        return 2
    if node is not None and node.done.done():
        return node.done.result()[0]
    return 0


def _say(error: InputError) -> str:
    print(f"ecyl: {error}", file=sys.stderr)
    return str(error)


def _spin_in_batches(executor: Executor, node: DriveNode) -> None:
    """Handle all that has come, sleep, and so on: one wake-up for many messages.

    Only two calls in a row without a message mean that none is there: where rclpy waits with no
    timeout, it takes one message of each topic and then returns once without, whatever is queued.
    """
    idle = 0
    while rclpy.ok() and not node.done.done():
        before = node.handled
        executor.spin_once(timeout_sec=0.0)
        idle = 0 if node.handled != before else idle + 1
        if idle > 1:
            time.sleep(node.batch_s)
            idle = 0
