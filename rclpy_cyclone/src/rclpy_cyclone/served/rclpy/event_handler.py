"""Events of the middleware: matches, incompatible QoS, missed deadlines."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum
from typing import Any, ClassVar

from rclpy._rclpy_pybind11 import UnsupportedEventTypeError
from rclpy.qos import QoSPolicyKind, qos_policy_name_from_kind
from rclpy.waitable import Waitable
from rclpy_cyclone.dds import clib, events


class QoSPublisherEventType(IntEnum):
    """Events of a publisher."""

    RCL_PUBLISHER_OFFERED_DEADLINE_MISSED = 0
    RCL_PUBLISHER_LIVELINESS_LOST = 1
    RCL_PUBLISHER_OFFERED_INCOMPATIBLE_QOS = 2
    RCL_PUBLISHER_INCOMPATIBLE_TYPE = 3
    RCL_PUBLISHER_MATCHED = 4


class QoSSubscriptionEventType(IntEnum):
    """Events of a subscription."""

    RCL_SUBSCRIPTION_REQUESTED_DEADLINE_MISSED = 0
    RCL_SUBSCRIPTION_LIVELINESS_CHANGED = 1
    RCL_SUBSCRIPTION_REQUESTED_INCOMPATIBLE_QOS = 2
    RCL_SUBSCRIPTION_MESSAGE_LOST = 3
    RCL_SUBSCRIPTION_INCOMPATIBLE_TYPE = 4
    RCL_SUBSCRIPTION_MATCHED = 5


@dataclass
class _Counted:
    total_count: int = 0
    total_count_change: int = 0


class QoSRequestedDeadlineMissedInfo(_Counted):
    """A subscription got no message within its deadline."""


class QoSOfferedDeadlineMissedInfo(_Counted):
    """A publisher published nothing within its deadline."""


class QoSLivelinessLostInfo(_Counted):
    """A publisher did not show life in time."""


class QoSMessageLostInfo(_Counted):
    """Messages were lost."""


class IncompatibleTypeInfo(_Counted):
    """An endpoint of the topic has another type."""


@dataclass
class QoSRequestedIncompatibleQoSInfo(_Counted):
    """An endpoint of the topic has a QoS that does not match."""

    last_policy_kind: QoSPolicyKind = QoSPolicyKind.INVALID


QoSOfferedIncompatibleQoSInfo = QoSRequestedIncompatibleQoSInfo


@dataclass
class QoSLivelinessChangedInfo:
    """Publishers of the topic came to life or ceased to show it."""

    alive_count: int = 0
    not_alive_count: int = 0
    alive_count_change: int = 0
    not_alive_count_change: int = 0


@dataclass
class QoSSubscriptionMatchedInfo(_Counted):
    """Endpoints of the topic were matched, or are no more."""

    current_count: int = 0
    current_count_change: int = 0


QoSPublisherMatchedInfo = QoSSubscriptionMatchedInfo

# DDS numbers of policies -> ours
_POLICIES = {
    2: QoSPolicyKind.DURABILITY,
    4: QoSPolicyKind.DEADLINE,
    8: QoSPolicyKind.LIVELINESS,
    11: QoSPolicyKind.RELIABILITY,
    13: QoSPolicyKind.HISTORY,
    21: QoSPolicyKind.LIFESPAN,
}
_P, _S = QoSPublisherEventType, QoSSubscriptionEventType
# Event -> (status bit, name of the C function and of its status, class of the information)
_KINDS: dict[Any, tuple[int, str, Any]] = {
    ("pub", _P.RCL_PUBLISHER_OFFERED_DEADLINE_MISSED): (
        clib.OFFERED_DEADLINE_MISSED,
        "offered_deadline_missed",
        QoSOfferedDeadlineMissedInfo,
    ),
    ("pub", _P.RCL_PUBLISHER_LIVELINESS_LOST): (
        clib.LIVELINESS_LOST,
        "liveliness_lost",
        QoSLivelinessLostInfo,
    ),
    ("pub", _P.RCL_PUBLISHER_OFFERED_INCOMPATIBLE_QOS): (
        clib.OFFERED_INCOMPATIBLE_QOS,
        "offered_incompatible_qos",
        QoSOfferedIncompatibleQoSInfo,
    ),
    ("pub", _P.RCL_PUBLISHER_MATCHED): (
        clib.PUBLICATION_MATCHED,
        "publication_matched",
        QoSPublisherMatchedInfo,
    ),
    ("sub", _S.RCL_SUBSCRIPTION_REQUESTED_DEADLINE_MISSED): (
        clib.REQUESTED_DEADLINE_MISSED,
        "requested_deadline_missed",
        QoSRequestedDeadlineMissedInfo,
    ),
    ("sub", _S.RCL_SUBSCRIPTION_LIVELINESS_CHANGED): (
        clib.LIVELINESS_CHANGED,
        "liveliness_changed",
        QoSLivelinessChangedInfo,
    ),
    ("sub", _S.RCL_SUBSCRIPTION_REQUESTED_INCOMPATIBLE_QOS): (
        clib.REQUESTED_INCOMPATIBLE_QOS,
        "requested_incompatible_qos",
        QoSRequestedIncompatibleQoSInfo,
    ),
    ("sub", _S.RCL_SUBSCRIPTION_MESSAGE_LOST): (
        clib.SAMPLE_LOST,
        "sample_lost",
        QoSMessageLostInfo,
    ),
    ("sub", _S.RCL_SUBSCRIPTION_MATCHED): (
        clib.SUBSCRIPTION_MATCHED,
        "subscription_matched",
        QoSSubscriptionMatchedInfo,
    ),
}


class EventHandler(Waitable):
    """Calls a function on an event of an endpoint.

    :param callback_group: the function's group.
    :param callback: the function; it gets information on the event.
    :param event_type: which event.
    :param parent_impl: the publisher or subscription.
    :raises UnsupportedEventTypeError: if the middleware does not tell of such events.
    """

    def __init__(
        self,
        *,
        callback_group: Any,
        callback: Callable[[Any], Any],
        event_type: Any,
        parent_impl: Any,
    ) -> None:
        super().__init__(callback_group)
        self.event_type = event_type
        self.callback = callback
        side = "pub" if isinstance(event_type, QoSPublisherEventType) else "sub"
        if (side, event_type) not in _KINDS:
            raise UnsupportedEventTypeError(f"event type {event_type.name} is not supported")
        self._bit, self._status, self._info_class = _KINDS[side, event_type]
        self._source = events.source(parent_impl, side)
        self._source.add(self._bit)
        self._waits.append((self._source.entity, self._source.look))
        self._source.listeners[self._bit] = self._triggered
        self._has = False

    def _triggered(self) -> None:
        self._has = True
        self._ready()

    def _pending(self) -> bool:
        return self._has

    def _take(self) -> tuple[Any, tuple[Any, ...]] | None:
        self._has = False
        raw = self._source.status(self._status)
        names = self._info_class.__dataclass_fields__
        values = {n: getattr(raw, n) for n in names if hasattr(raw, n)}
        if not any(v for n, v in values.items() if n.endswith("change")):
            return None
        info = self._info_class(**values)
        if hasattr(info, "last_policy_kind"):
            info.last_policy_kind = _POLICIES.get(raw.last_policy_id, QoSPolicyKind.INVALID)
        return self.callback, (info,)

    def destroy(self) -> None:
        """Stop listening."""
        self._source.listeners.pop(self._bit, None)
        super().destroy()


class QoSEventHandler(EventHandler):
    """Deprecated name of :class:`EventHandler`."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        warnings.warn(
            "QoSEventHandler is deprecated, use EventHandler instead.",
            DeprecationWarning,
            stacklevel=2,
        )
        super().__init__(*args, **kwargs)


class _Callbacks:
    """Common part of the two containers of callbacks."""

    use_default_callbacks: bool
    _events: ClassVar[dict[str, Any]]
    _warning: str

    def create_event_handlers(
        self, callback_group: Any, parent: Any, topic_name: str, logger: Any
    ) -> list[EventHandler]:
        """Return a handler for each callback that is given, or that has a default."""
        handlers = []
        for name, event_type in self._events.items():
            callback = getattr(self, name)
            if callback is None:
                if name != "incompatible_qos" or not self.use_default_callbacks:
                    continue
                callback = self._default(topic_name, logger)
            handlers.append(
                EventHandler(
                    callback_group=callback_group,
                    callback=callback,
                    event_type=event_type,
                    parent_impl=parent,
                )
            )
        return handlers

    def _default(self, topic: str, logger: Any) -> Callable[[Any], None]:
        def warn(event: Any) -> None:
            policy = qos_policy_name_from_kind(event.last_policy_kind)
            logger.warning(f"{self._warning.format(topic)} Last incompatible policy: {policy}")

        return warn


class SubscriptionEventCallbacks(_Callbacks):
    """What a subscription shall call on events.

    :param deadline: a deadline was missed.
    :param incompatible_qos: a publisher's QoS does not match; by default that is logged.
    :param liveliness: the liveliness of a publisher changed.
    :param message_lost: messages were lost.
    :param incompatible_type: a publisher has another type; Cyclone does not tell.
    :param matched: a publisher came or went.
    :param use_default_callbacks: whether there are defaults.
    """

    _events: ClassVar[dict[str, Any]] = {
        "deadline": _S.RCL_SUBSCRIPTION_REQUESTED_DEADLINE_MISSED,
        "incompatible_qos": _S.RCL_SUBSCRIPTION_REQUESTED_INCOMPATIBLE_QOS,
        "liveliness": _S.RCL_SUBSCRIPTION_LIVELINESS_CHANGED,
        "message_lost": _S.RCL_SUBSCRIPTION_MESSAGE_LOST,
        "incompatible_type": _S.RCL_SUBSCRIPTION_INCOMPATIBLE_TYPE,
        "matched": _S.RCL_SUBSCRIPTION_MATCHED,
    }
    _warning = (
        "New publisher discovered on topic '{}', offering incompatible QoS. "
        "No messages will be received from it."
    )

    def __init__(
        self,
        *,
        deadline: Callable[[Any], None] | None = None,
        incompatible_qos: Callable[[Any], None] | None = None,
        liveliness: Callable[[Any], None] | None = None,
        message_lost: Callable[[Any], None] | None = None,
        incompatible_type: Callable[[Any], None] | None = None,
        matched: Callable[[Any], None] | None = None,
        use_default_callbacks: bool = True,
    ) -> None:
        self.deadline = deadline
        self.incompatible_qos = incompatible_qos
        self.liveliness = liveliness
        self.message_lost = message_lost
        self.incompatible_type = incompatible_type
        self.matched = matched
        self.use_default_callbacks = use_default_callbacks


class PublisherEventCallbacks(_Callbacks):
    """What a publisher shall call on events.

    :param deadline: a deadline was missed.
    :param liveliness: the publisher did not show life in time.
    :param incompatible_qos: a subscription's QoS does not match; by default that is logged.
    :param incompatible_type: a subscription has another type; Cyclone does not tell.
    :param matched: a subscription came or went.
    :param use_default_callbacks: whether there are defaults.
    """

    _events: ClassVar[dict[str, Any]] = {
        "deadline": _P.RCL_PUBLISHER_OFFERED_DEADLINE_MISSED,
        "liveliness": _P.RCL_PUBLISHER_LIVELINESS_LOST,
        "incompatible_qos": _P.RCL_PUBLISHER_OFFERED_INCOMPATIBLE_QOS,
        "incompatible_type": _P.RCL_PUBLISHER_INCOMPATIBLE_TYPE,
        "matched": _P.RCL_PUBLISHER_MATCHED,
    }
    _warning = (
        "New subscription discovered on topic '{}', requesting incompatible QoS. "
        "No messages will be sent to it."
    )

    def __init__(
        self,
        *,
        deadline: Callable[[Any], None] | None = None,
        liveliness: Callable[[Any], None] | None = None,
        incompatible_qos: Callable[[Any], None] | None = None,
        incompatible_type: Callable[[Any], None] | None = None,
        matched: Callable[[Any], None] | None = None,
        use_default_callbacks: bool = True,
    ) -> None:
        self.deadline = deadline
        self.liveliness = liveliness
        self.incompatible_qos = incompatible_qos
        self.incompatible_type = incompatible_type
        self.matched = matched
        self.use_default_callbacks = use_default_callbacks
