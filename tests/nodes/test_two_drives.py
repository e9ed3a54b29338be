"""Two drives at once, each in its namespace, as docs/nodes.md starts them."""

from __future__ import annotations

import math

from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

from .conftest import Listener, node

SIDES = ("left", "right")
NEAR_M = 2e-4


class Side:
    """One drive's setpoints, and where its rod has been."""

    def __init__(self, listener: Listener, name: str) -> None:
        self.setpoints = listener.create_publisher(Float64, f"/{name}/ecyl/setpoint", 10)
        self.rod: list[float] = []
        listener.create_subscription(
            JointState,
            f"/{name}/ecyl/joint_states",
            lambda message: self.rod.append(message.position[1]),
            1000,
        )

    def ready(self) -> bool:
        """Whether it is heard and hears, for long enough that its limits let it go a way."""
        return len(self.rod) > 25 and self.setpoints.get_subscription_count() > 0

    def at(self, position: float) -> bool:
        """Whether its rod is there now."""
        return abs(self.rod[-1] - position) < NEAR_M


def test_two_drives_follow_their_own_setpoints(listener) -> None:
    """Lockstep, one domain: each moves to its own setpoint while the other stays where it is, on a
    clock of its own; when one has ended, the other still moves."""
    nodes = {
        (side, name): node(name, drive="servo_1khz", namespace=f"/{side}")
        for side in SIDES
        for name in ("plant", "controller", "reference")
    }
    left, right = (Side(listener, side) for side in SIDES)
    assert listener.until(lambda: left.ready() and right.ready())
    left.setpoints.publish(Float64(data=0.01))
    assert listener.until(lambda: left.at(0.01))
    assert max(map(abs, right.rod)) < NEAR_M
    seen = len(left.rod)
    right.setpoints.publish(Float64(data=-0.02))
    assert listener.until(lambda: right.at(-0.02))
    assert all(abs(one - 0.01) < 5e-4 for one in left.rod[seen:])
    for side in SIDES:
        status = f"{side}/ecyl/reference setpoints"
        assert listener.until(
            lambda status=status: listener.statuses.get(status, {}).get("setpoints_accepted") == "1"
        ), listener.statuses
    topics = {name for name, _ in listener.get_topic_names_and_types()}
    assert {"/left/clock", "/right/clock"} <= topics and "/clock" not in topics
    assert math.isnan(listener.rod)  # nothing outside the namespaces
    nodes["left", "plant"].kill()
    right.setpoints.publish(Float64(data=0.0))
    assert listener.until(lambda: right.at(0.0))
