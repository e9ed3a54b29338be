"""QoS policies that can be changed by parameters."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import rclpy.qos
from rclpy.duration import Duration
from rclpy.exceptions import ParameterAlreadyDeclaredException
from rclpy.publisher import Publisher
from rclpy.qos import QoSPolicyKind, QoSProfile
from rclpy.subscription import Subscription


class InvalidQosOverridesError(Exception):
    """The callback refused a profile changed by parameters."""


_ENUMS = {
    QoSPolicyKind.HISTORY: rclpy.qos.HistoryPolicy,
    QoSPolicyKind.RELIABILITY: rclpy.qos.ReliabilityPolicy,
    QoSPolicyKind.DURABILITY: rclpy.qos.DurabilityPolicy,
    QoSPolicyKind.LIVELINESS: rclpy.qos.LivelinessPolicy,
}


class QoSOverridingOptions:
    """Which policies parameters may change.

    :param policy_kinds: the policies.
    :param callback: may refuse the resulting profile.
    :param entity_id: tells apart endpoints of the same topic.
    """

    def __init__(
        self,
        policy_kinds: Iterable[QoSPolicyKind],
        *,
        callback: Callable[[QoSProfile], Any] | None = None,
        entity_id: str | None = None,
    ) -> None:
        self._policy_kinds = policy_kinds
        self._callback = callback
        self._entity_id = entity_id

    @property
    def policy_kinds(self) -> Iterable[QoSPolicyKind]:
        """The policies."""
        return self._policy_kinds

    @property
    def callback(self) -> Callable[[QoSProfile], Any] | None:
        """May refuse the resulting profile."""
        return self._callback

    @property
    def entity_id(self) -> str | None:
        """Tells apart endpoints of the same topic."""
        return self._entity_id

    @classmethod
    def with_default_policies(
        cls,
        *,
        callback: Callable[[QoSProfile], Any] | None = None,
        entity_id: str | None = None,
    ) -> QoSOverridingOptions:
        """Return options for history, depth and reliability."""
        kinds = (QoSPolicyKind.HISTORY, QoSPolicyKind.DEPTH, QoSPolicyKind.RELIABILITY)
        return cls(policy_kinds=kinds, callback=callback, entity_id=entity_id)


def _declare_qos_parameters(
    entity_type: Any,
    node: Any,
    topic_name: str,
    qos: QoSProfile,
    options: QoSOverridingOptions,
) -> None:
    """Declare the parameters of an endpoint's policies, and change the profile by them."""
    if not issubclass(entity_type, (Publisher, Subscription)):
        raise TypeError("Argument `entity_type` should be a subclass of Publisher or Subscription")
    kind = "publisher" if issubclass(entity_type, Publisher) else "subscription"
    suffix = "" if options.entity_id is None else f"_{options.entity_id}"
    about = f" for {kind} `{topic_name}` with id `{options.entity_id}`"
    for policy in options.policy_kinds:
        if policy == QoSPolicyKind.LIFESPAN and kind == "subscription":
            continue
        from rcl_interfaces.msg import ParameterDescriptor

        word = policy.name.lower()
        name = f"qos_overrides.{topic_name}.{kind}{suffix}.{word}"
        descriptor = ParameterDescriptor(description=word + about, read_only=True)
        try:
            parameter = node.declare_parameter(name, _value(qos, policy), descriptor)
        except ParameterAlreadyDeclaredException:
            parameter = node.get_parameter(name)
        _override(qos, policy, parameter.value)
    if options.callback is not None:
        result = options.callback(qos)
        if not result.successful:
            raise InvalidQosOverridesError(
                f"Provided QoS overrides{about}, are not valid: {result.reason}"
            )


def _value(qos: QoSProfile, policy: QoSPolicyKind) -> Any:
    value = getattr(qos, policy.name.lower())
    if policy in _ENUMS:
        if value.name == "UNKNOWN":
            raise ValueError("User provided QoS profile is invalid")
        return value.name.lower()
    return value.nanoseconds if isinstance(value, Duration) else value


def _override(qos: QoSProfile, policy: QoSPolicyKind, value: Any) -> None:
    word = policy.name.lower()
    if policy in _ENUMS:
        try:
            value = _ENUMS[policy][value.upper()]
        except KeyError:
            raise RuntimeError(f"Unexpected QoS override for policy `{word}`: `{value}`") from None
    elif isinstance(getattr(qos, word), Duration):
        value = Duration(nanoseconds=value)
    setattr(qos, word, value)
