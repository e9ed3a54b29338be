"""What rclpy can do with a message to another process and back: a bare Float64 ping-pong.

Two nodes that know nothing but each other, each spun by rclpy's SingleThreadedExecutor: what a
user's own two nodes would do. Runs on whichever rclpy there is. Prints round trips a second and
their quantiles as JSON.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import time

PATIENCE_S = 20.0
QUIET_S = 5.0  # the echo ends when nothing has come for so long


def _node(name: str, reads: str, writes: str, answer):  # type: ignore[no-untyped-def]
    import rclpy
    from std_msgs.msg import Float64

    node = rclpy.create_node(name)
    publisher = node.create_publisher(Float64, writes, 10)
    node.create_subscription(Float64, reads, lambda message: answer(publisher, message), 10)
    return node, publisher


def echo() -> None:
    """The other process: send back what comes."""
    import rclpy
    from rclpy.executors import SingleThreadedExecutor

    heard = [time.monotonic() + PATIENCE_S]

    def answer(publisher, message) -> None:  # type: ignore[no-untyped-def]
        heard[0] = time.monotonic()
        publisher.publish(message)

    rclpy.init()
    node, _ = _node("echo", "ping", "pong", answer)
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    while time.monotonic() - heard[0] < QUIET_S:
        executor.spin_once(timeout_sec=1.0)
    rclpy.shutdown()


def ping(seconds: float) -> dict[str, float]:
    """Trips a second; median and 99th percentile of a trip and CPU time a trip on this side, s."""
    import rclpy
    from rclpy.executors import SingleThreadedExecutor
    from std_msgs.msg import Float64

    took: list[float] = []
    sent = [0.0]

    def again(publisher, message) -> None:  # type: ignore[no-untyped-def]
        now = time.perf_counter()
        took.append(now - sent[0])
        sent[0] = now
        publisher.publish(message)

    rclpy.init()
    node, publisher = _node("ping", "pong", "ping", again)
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    deadline = time.monotonic() + PATIENCE_S
    while not took and time.monotonic() < deadline:  # until both directions are matched
        if publisher.get_subscription_count():
            sent[0] = time.perf_counter()
            publisher.publish(Float64())
        executor.spin_once(timeout_sec=0.2)
    if not took:
        raise RuntimeError("a message did not come back")
    took.clear()
    begin, cpu = time.perf_counter(), time.process_time()
    while time.perf_counter() - begin < seconds:
        executor.spin_once(timeout_sec=1.0)
    elapsed, cpu = time.perf_counter() - begin, time.process_time() - cpu
    rclpy.shutdown()
    took.sort()
    return {
        "trips_per_s": len(took) / elapsed,
        "median_s": took[len(took) // 2],
        "p99_s": took[int(0.99 * len(took))],
        "cpu_per_trip_s": cpu / len(took),
    }


def measured(seconds: float) -> dict[str, float]:
    """The same, in two new processes."""
    command = [sys.executable, __file__, str(seconds), "--end"]
    other = subprocess.Popen([*command, "echo"])
    try:
        done = subprocess.run([*command, "ping"], check=True, capture_output=True, text=True)
        return dict(json.loads(done.stdout))
    finally:
        other.kill()
        other.wait()


def main() -> None:
    """Both ends in two processes, or one end in this."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("seconds", type=float, nargs="?", default=10.0, help="to measure for (10)")
    parser.add_argument("--end", choices=("ping", "echo"), help="only this, in this process")
    options = parser.parse_args()
    if options.end == "echo":
        echo()
    else:
        print(json.dumps((ping if options.end else measured)(options.seconds)))


if __name__ == "__main__":
    main()
