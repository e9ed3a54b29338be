"""Messages taken directly where rclpy lets them be; otherwise rclpy's own executor, and a word."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
import rclpy
from rclpy.executors import Executor
from rclpy.node import Node
from rclpy.subscription import Subscription
from rclpy.task import Future
from std_msgs.msg import Float64

from ecyl_ros.nodes import direct_executor
from ecyl_ros.nodes.direct_executor import DirectExecutor, make_executor

GENUINE = not direct_executor.takes_directly()


class Bystander(Node):
    """Hears itself, has a timer and the parameter services; keeps what its logger is told."""

    def __init__(self) -> None:
        super().__init__("bystander")
        self.got: list[float] = []
        self.ticks = 0
        self.said: list[str] = []
        self.both: Future = Future()
        self.publisher = self.create_publisher(Float64, "t", 10)
        self.create_subscription(Float64, "t", self._hear, 10)
        self.create_timer(0.01, self._tick)

    def _hear(self, message: Float64) -> None:
        self.got.append(message.data)

    def _tick(self) -> None:
        self.ticks += 1
        if self.got and not self.both.done():
            self.both.set_result(None)

    def get_logger(self):
        """Itself."""
        return self

    def warning(self, text: str) -> None:
        """Keep it."""
        self.said.append(text)


@pytest.fixture
def bystander() -> Iterator[Bystander]:
    rclpy.init(args=[])
    made = Bystander()
    yield made
    made.destroy_node()
    rclpy.try_shutdown()


def _works(executor: Executor, node: Bystander) -> None:
    """Messages and timers come through the executor."""
    node.publisher.publish(Float64(data=3.0))
    executor.spin_until_future_complete(node.both, 20.0)
    assert node.got == [3.0] and node.ticks


def test_this_rclpys_nodes_get_the_quick_executor(bystander: Bystander) -> None:
    """Whichever rclpy there is has all that is needed, and nothing is said."""
    executor = make_executor(bystander)
    assert isinstance(executor, DirectExecutor) == GENUINE and bystander.said == []
    assert list(executor.get_nodes()) == [bystander]
    _works(executor, bystander)


def test_a_subscription_may_be_replaced_in_a_callback(bystander: Bystander) -> None:
    """In a message's or a timer's: the new one gets the messages, the old one is let be."""
    executor = make_executor(bystander)
    heard: list[int] = []
    done: Future = Future()
    now: list[Subscription] = []

    def subscribe() -> None:
        number = len(now)
        now.append(bystander.create_subscription(Float64, "t", lambda _: hear(number), 10))

    def replace() -> None:
        bystander.destroy_subscription(now[-1])
        subscribe()

    def hear(number: int) -> None:
        heard.append(number)
        if number == 0:
            replace()
        elif number == 2 and not done.done():
            done.set_result(None)

    def tick() -> None:
        if heard and heard[-1] == 1 and len(now) == 2:
            replace()
        for _ in range(2):  # one more is waiting when a callback has ended its subscription
            bystander.publisher.publish(Float64(data=1.0))

    subscribe()
    bystander.create_timer(0.02, tick)
    executor.spin_until_future_complete(done, 20.0)
    assert done.done() and sorted(set(heard)) == [0, 1, 2] and heard.count(0) == 1


def test_an_rclpy_of_other_internals_spins_the_nodes_itself(
    bystander: Bystander, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where its handles are of another kind: one warning with the reason, and the nodes work."""
    if GENUINE:

        def lacks(*arguments: object, **named: object) -> None:
            raise AttributeError("no take_message of the kind known\nmore that nobody reads")

        monkeypatch.setattr(direct_executor, "_Inbox", lacks)
    else:  # the stand-in's handles are of another kind
        monkeypatch.setattr(direct_executor, "takes_directly", lambda: False)
    executor = make_executor(bystander)
    assert not isinstance(executor, DirectExecutor)
    (line,) = bystander.said
    assert "(AttributeError: " in line and "take_message" in line and "\n" not in line
    _works(executor, bystander)
