"""Making and keeping what a node consists of."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy import _qos_mapping
from rclpy.callback_groups import CallbackGroup
from rclpy.client import Client
from rclpy.clock import Clock
from rclpy.constants import S_TO_NS
from rclpy.context import Context
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.guard_condition import GuardCondition
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile, qos_profile_services_default
from rclpy.qos_overriding_options import QoSOverridingOptions, _declare_qos_parameters
from rclpy.service import Service
from rclpy.subscription import Subscription
from rclpy.timer import Rate, Timer
from rclpy.type_support import check_is_valid_msg_type, check_is_valid_srv_type


class NodeEntities:
    """Part of :class:`.Node`: publishers, subscriptions, services, clients, timers."""

    executor: Any
    _announcing: bool
    _clock: Clock
    _context: Context
    _default_callback_group: CallbackGroup
    _participant: Any
    _rate_group: CallbackGroup
    _resolve: Callable[..., str]

    def _init_entities(self) -> None:
        self._publishers: list[Publisher] = []
        self._subscriptions: list[Subscription] = []
        self._clients: list[Client] = []
        self._services: list[Service] = []
        self._timers: list[Timer] = []
        self._guards: list[GuardCondition] = []
        self._waitables: list[Any] = []

    def _entities(self) -> list[Any]:
        return [
            *self._timers,
            *self._subscriptions,
            *self._guards,
            *self._clients,
            *self._services,
            *self._waitables,
        ]

    def create_publisher(
        self,
        msg_type: Any,
        topic: str,
        qos_profile: QoSProfile | int,
        *,
        callback_group: CallbackGroup | None = None,
        event_callbacks: PublisherEventCallbacks | None = None,
        qos_overriding_options: QoSOverridingOptions | None = None,
        publisher_class: Any = Publisher,
    ) -> Any:
        """Return a new publisher.

        :param msg_type: class of the messages.
        :param topic: name of the topic.
        :param qos_profile: a profile, or the depth of a default one.
        :param callback_group: group of the event callbacks.
        :param event_callbacks: what to call on events of the middleware.
        :param qos_overriding_options: which policies parameters may change.
        :param publisher_class: class of the publisher.
        """
        profile, full = self._endpoint(Publisher, topic, qos_profile, qos_overriding_options)
        check_is_valid_msg_type(msg_type)
        publisher = publisher_class(
            self,
            msg_type,
            topic,
            profile,
            event_callbacks or PublisherEventCallbacks(),
            callback_group or self._default_callback_group,
            _qos_mapping.policies(profile, self, full, publisher=True),
            full,
        )
        self._publishers.append(publisher)
        for handler in publisher.event_handlers:
            self.add_waitable(handler)
        self._endpoints_changed()
        return publisher

    def create_subscription(
        self,
        msg_type: Any,
        topic: str,
        callback: Callable[..., Any],
        qos_profile: QoSProfile | int,
        *,
        callback_group: CallbackGroup | None = None,
        event_callbacks: SubscriptionEventCallbacks | None = None,
        qos_overriding_options: QoSOverridingOptions | None = None,
        raw: bool = False,
    ) -> Subscription:
        """Return a new subscription.

        :param msg_type: class of the messages.
        :param topic: name of the topic.
        :param callback: called with a message, and with information on it if it takes two.
        :param qos_profile: a profile, or the depth of a default one.
        :param callback_group: group of the callback.
        :param event_callbacks: what to call on events of the middleware.
        :param qos_overriding_options: which policies parameters may change.
        :param raw: whether the callback gets the CDR representation as ``bytes``.
        """
        profile, full = self._endpoint(Subscription, topic, qos_profile, qos_overriding_options)
        check_is_valid_msg_type(msg_type)
        group = callback_group or self._default_callback_group
        subscription = Subscription(
            self,
            msg_type,
            topic,
            callback,
            group,
            profile,
            raw,
            event_callbacks or SubscriptionEventCallbacks(),
            _qos_mapping.policies(profile, self, full, publisher=False),
            full,
        )
        self._add(subscription, self._subscriptions, group)
        for handler in subscription.event_handlers:
            self.add_waitable(handler)
        self._endpoints_changed()
        return subscription

    def _endpoint(
        self, kind: Any, topic: str, qos: QoSProfile | int, options: QoSOverridingOptions | None
    ) -> tuple[QoSProfile, str]:
        profile = self._validate_qos_or_depth_parameter(qos)
        full = self._resolve(topic, "topic")
        _declare_qos_parameters(kind, self, full, profile, options or QoSOverridingOptions([]))
        return profile, full

    def _validate_qos_or_depth_parameter(self, qos_or_depth: Any) -> QoSProfile:
        if isinstance(qos_or_depth, QoSProfile):
            return qos_or_depth
        if not isinstance(qos_or_depth, int):
            raise TypeError(f"Expected QoSProfile or int, but received {type(qos_or_depth)!r}")
        if qos_or_depth < 0:
            raise ValueError("history depth must be greater than or equal to zero")
        return QoSProfile(depth=qos_or_depth)

    def _add(self, entity: Any, where: list[Any], group: CallbackGroup) -> None:
        group.add_entity(entity)
        where.append(entity)
        executor = self.executor
        if executor is not None:
            entity._attach(executor)

    def _endpoints_changed(self) -> None:
        if self._announcing:
            self._participant.announce()

    def create_client(
        self,
        srv_type: Any,
        srv_name: str,
        *,
        qos_profile: QoSProfile = qos_profile_services_default,
        callback_group: CallbackGroup | None = None,
    ) -> Client:
        """Return a new client of a service.

        :param srv_type: class of the service.
        :param srv_name: name of the service.
        :param qos_profile: profile of requests and responses.
        :param callback_group: group in which responses are handled.
        """
        check_is_valid_srv_type(srv_type)
        full = self._resolve(srv_name, "service")
        group = callback_group or self._default_callback_group
        policies = _qos_mapping.policies(qos_profile, self, full, publisher=None)
        client = Client(self, srv_type, srv_name, qos_profile, group, policies, full)
        self._add(client, self._clients, group)
        self._endpoints_changed()
        return client

    def create_service(
        self,
        srv_type: Any,
        srv_name: str,
        callback: Callable[[Any, Any], Any],
        *,
        qos_profile: QoSProfile = qos_profile_services_default,
        callback_group: CallbackGroup | None = None,
    ) -> Service:
        """Return a new service.

        :param srv_type: class of the service.
        :param srv_name: name of the service.
        :param callback: called with a request and a response to be filled in and returned.
        :param qos_profile: profile of requests and responses.
        :param callback_group: group of the callback.
        """
        check_is_valid_srv_type(srv_type)
        full = self._resolve(srv_name, "service")
        group = callback_group or self._default_callback_group
        policies = _qos_mapping.policies(qos_profile, self, full, publisher=None)
        service = Service(self, srv_type, srv_name, callback, group, qos_profile, policies, full)
        self._add(service, self._services, group)
        self._endpoints_changed()
        return service

    def create_timer(
        self,
        timer_period_sec: float,
        callback: Callable[[], Any] | None,
        callback_group: CallbackGroup | None = None,
        clock: Clock | None = None,
        autostart: bool = True,
    ) -> Timer:
        """Return a new timer.

        :param timer_period_sec: period in seconds.
        :param callback: called without arguments.
        :param callback_group: group of the callback.
        :param clock: by default the node's clock.
        :param autostart: whether to start now, rather than at ``reset()``.
        """
        period = int(float(timer_period_sec) * S_TO_NS)
        group = callback_group or self._default_callback_group
        timer = Timer(
            callback,
            group,
            period,
            self._clock if clock is None else clock,
            context=self._context,
            autostart=autostart,
        )
        self._add(timer, self._timers, group)
        return timer

    def create_guard_condition(
        self, callback: Callable[[], Any], callback_group: CallbackGroup | None = None
    ) -> GuardCondition:
        """Return a new guard condition."""
        group = callback_group or self._default_callback_group
        guard = GuardCondition(callback, group, context=self._context)
        self._add(guard, self._guards, group)
        return guard

    def create_rate(self, frequency: float, clock: Clock | None = None) -> Rate:
        """Return a new rate.

        :param frequency: in hertz.
        :param clock: by default the node's clock.
        :raises ValueError: if the frequency is not positive.
        """
        if frequency <= 0:
            raise ValueError("frequency must be > 0")
        timer = self.create_timer(1.0 / frequency, None, self._rate_group, clock)
        return Rate(timer, context=self._context)

    def add_waitable(self, waitable: Any) -> None:
        """Let the executor run something else."""
        self._waitables.append(waitable)
        if self.executor is not None:
            waitable._attach(self.executor)

    def remove_waitable(self, waitable: Any) -> None:
        """Undo :meth:`add_waitable`."""
        self._waitables.remove(waitable)
        waitable._detach()
