"""Translation of a QoS profile to DDS and back.

Profiles are given as plain values here: see :class:`Policies`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from cyclonedds.qos import Policy, Qos, _CQos

from rclpy_cyclone.dds.clib import INFINITY

SECONDS = 1_000_000_000
UNSPECIFIED = 0
INFINITE = 9223372036854775807


@dataclass
class Policies:
    """The policies of an endpoint. Durations are in nanoseconds, 0 stands for unspecified."""

    keep_all: bool = False
    depth: int = 10
    reliable: bool = True
    transient_local: bool = False
    deadline: int = 0
    lifespan: int = 0
    manual_liveliness: bool = False
    lease: int = 0

    def timed(self) -> bool:
        """Say whether DDS must see every sample for the timing policies to hold."""
        durations = (self.deadline, self.lifespan, self.lease)
        return self.manual_liveliness or any(d not in (0, INFINITE) for d in durations)


def _dds(duration: int) -> int:
    return INFINITY if duration in (UNSPECIFIED, INFINITE) else duration


def endpoint_qos(policies: Policies, user_data: bytes, ignore_local: bool) -> Qos:
    """Return the DDS QoS of a reader or writer.

    :param ignore_local: whether a reader gets nothing from writers of its own participant.
    """
    history: Any = Policy.History.KeepAll
    if not policies.keep_all:
        history = Policy.History.KeepLast(max(policies.depth, 1))
    chosen: list[Any] = [
        history,
        Policy.Reliability.Reliable(INFINITY)
        if policies.reliable
        else Policy.Reliability.BestEffort,
        Policy.WriterDataLifecycle(autodispose=False),
        Policy.Userdata(user_data),
    ]
    if policies.transient_local:
        chosen.append(Policy.Durability.TransientLocal)
        chosen.append(Policy.DurabilityService(0, history, -1, -1, -1))
    else:
        chosen.append(Policy.Durability.Volatile)
    if policies.deadline:
        chosen.append(Policy.Deadline(_dds(policies.deadline)))
    if policies.lifespan:
        chosen.append(Policy.Lifespan(_dds(policies.lifespan)))
    if policies.manual_liveliness:
        chosen.append(Policy.Liveliness.ManualByTopic(_dds(policies.lease)))
    else:
        chosen.append(Policy.Liveliness.Automatic(_dds(policies.lease)))
    if ignore_local:
        chosen.append(Policy.IgnoreLocal.Participant)
    return Qos(*chosen)


def participant_qos(user_data: bytes) -> Qos:
    """Return the DDS QoS of a participant."""
    return Qos(Policy.Userdata(user_data))


def c_qos(qos: Qos) -> Any:
    """Return a C handle of a QoS, to be given to :func:`free`."""
    return _CQos.qos_to_cqos(qos)


def free(handle: Any) -> None:
    """Free a C handle."""
    _CQos.cqos_destroy(handle)


def policies_of(qos: Qos) -> Policies:
    """Return the policies of a discovered endpoint."""
    found = Policies()
    history = qos[Policy.History] if Policy.History in qos else None  # noqa: SIM401
    found.depth = 0
    if history is Policy.History.KeepAll:
        found.keep_all = True
    elif history is not None:
        found.depth = history.depth
    found.reliable = (
        Policy.Reliability in qos and qos[Policy.Reliability] is not Policy.Reliability.BestEffort
    )
    found.transient_local = (
        Policy.Durability in qos and qos[Policy.Durability] is not Policy.Durability.Volatile
    )
    found.deadline = _ros(qos[Policy.Deadline].deadline if Policy.Deadline in qos else INFINITY)
    found.lifespan = _ros(qos[Policy.Lifespan].lifespan if Policy.Lifespan in qos else INFINITY)
    lively = qos[Policy.Liveliness] if Policy.Liveliness in qos else None  # noqa: SIM401
    found.lease = _ros(lively.lease_duration if lively is not None else INFINITY)
    found.manual_liveliness = isinstance(lively, Policy.Liveliness.ManualByTopic)
    return found


def _ros(duration: int) -> int:
    return INFINITE if duration >= INFINITY else duration


def refusal(offered: Policies, requested: Policies) -> str | None:
    """Return the policy for which a writer and a reader do not match, ``None`` if they do."""
    if requested.reliable and not offered.reliable:
        return "RELIABILITY"
    if requested.transient_local and not offered.transient_local:
        return "DURABILITY"
    if _dds(offered.deadline) > _dds(requested.deadline):
        return "DEADLINE"
    if requested.manual_liveliness and not offered.manual_liveliness:
        return "LIVELINESS"
    if _dds(offered.lease) > _dds(requested.lease):
        return "LIVELINESS"
    return None
