"""From a QoS profile to the policies of an endpoint."""

from __future__ import annotations

from typing import Any

from rclpy._rclpy_pybind11 import RCLError
from rclpy.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    LivelinessPolicy,
    QoSProfile,
    ReliabilityPolicy,
)
from rclpy_cyclone.dds import graph
from rclpy_cyclone.dds.qos import Policies


def policies(profile: QoSProfile, node: Any, name: str, *, publisher: bool | None) -> Policies:
    """Return the policies of an endpoint.

    ``BEST_AVAILABLE`` becomes the strictest policy that matches all endpoints known by now.

    :param publisher: whether it is a publisher; ``None`` for a service or client.
    :raises RCLError: if a policy is unknown.
    """
    for policy in (profile.history, profile.reliability, profile.durability, profile.liveliness):
        if policy.name == "UNKNOWN":
            raise RCLError(f"failed to create endpoint of {name}: a QoS policy is UNKNOWN")
    depth = profile.depth
    if profile.history != HistoryPolicy.KEEP_ALL and depth < 0:
        raise RCLError(f"failed to create endpoint of {name}: unsupported history depth")
    best = _best(profile, node, name, publisher)
    return Policies(
        keep_all=profile.history == HistoryPolicy.KEEP_ALL,
        depth=depth or 1,
        reliable=best("reliability", ReliabilityPolicy.BEST_EFFORT, "reliable"),
        transient_local=best("durability", DurabilityPolicy.VOLATILE, "transient_local"),
        deadline=_duration(profile.deadline.nanoseconds),
        lifespan=_duration(profile.lifespan.nanoseconds),
        manual_liveliness=profile.liveliness == LivelinessPolicy.MANUAL_BY_TOPIC,
        lease=_duration(profile.liveliness_lease_duration.nanoseconds),
    )


def _duration(nanoseconds: int) -> int:
    # The largest value but one stands for "best available", which asks for nothing.
    return 0 if nanoseconds == 9223372036854775806 else nanoseconds


def _best(profile: QoSProfile, node: Any, name: str, publisher: bool | None) -> Any:
    def choose(policy: str, weak: Any, field: str) -> bool:
        value = getattr(profile, policy)
        if value.name == "BEST_AVAILABLE":
            if publisher is None:
                return field == "reliable"
            if publisher:
                return True
            others = graph.publishers(node._participant, f"rt{name}")
            return all(getattr(o.policies, field) for o in others)
        if value.name == "SYSTEM_DEFAULT":
            return field == "reliable"
        return value != weak

    return choose
