"""Nodes."""

from __future__ import annotations

import weakref
from collections.abc import Callable, Iterator
from typing import Any

from rclpy import _qos_mapping, _rosout
from rclpy._node_graph import NodeGraph
from rclpy._node_parameters import NodeParameters
from rclpy._rclpy_pybind11 import RCLInvalidROSArgsError, UnknownROSArgsError
from rclpy.callback_groups import (
    CallbackGroup,
    MutuallyExclusiveCallbackGroup,
    ReentrantCallbackGroup,
)
from rclpy.client import Client
from rclpy.clock import Clock, ROSClock
from rclpy.constants import S_TO_NS
from rclpy.context import Context
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.exceptions import InvalidHandle, NotInitializedException
from rclpy.guard_condition import GuardCondition
from rclpy.logging import get_logger
from rclpy.parameter import Parameter
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile, qos_profile_parameter_events, qos_profile_services_default
from rclpy.qos_overriding_options import QoSOverridingOptions, _declare_qos_parameters
from rclpy.service import Service
from rclpy.subscription import Subscription
from rclpy.timer import Rate, Timer
from rclpy.type_support import check_is_valid_msg_type, check_is_valid_srv_type
from rclpy.utilities import get_default_context
from rclpy.validate_full_topic_name import validate_full_topic_name
from rclpy.validate_namespace import validate_namespace
from rclpy.validate_node_name import validate_node_name
from rclpy.validate_topic_name import validate_topic_name
from rclpy_cyclone import arguments, parameterfiles, remapping
from rclpy_cyclone.dds.participant import NodeEntry


class Node(NodeParameters, NodeGraph):
    """A node: publishers, subscriptions, services, clients, timers and parameters under a name.

    As a context manager it is destroyed on leaving.

    :param node_name: its name.
    :param context: the context, by default the default one.
    :param cli_args: command line of this node alone; ``--ros-args`` is implied.
    :param namespace: namespace for the names of the node and of what it makes.
    :param use_global_arguments: whether the process's command line applies.
    :param enable_rosout: whether log messages go to ``/rosout``.
    :param start_parameter_services: whether others can reach the parameters.
    :param parameter_overrides: values to be used instead of the declared defaults.
    :param allow_undeclared_parameters: whether parameters can be set without declaration.
    :param automatically_declare_parameters_from_overrides: whether all overrides are declared.
    :param enable_logger_service: whether others can reach the logger levels.
    :raises NotInitializedException: if the context is not valid.
    :raises InvalidNodeNameException: if the name is invalid.
    :raises InvalidNamespaceException: if the namespace is invalid.
    """

    PARAM_REL_TOL = 1e-6

    def __init__(
        self,
        node_name: str,
        *,
        context: Context | None = None,
        cli_args: list[str] | None = None,
        namespace: str | None = None,
        use_global_arguments: bool = True,
        enable_rosout: bool = True,
        start_parameter_services: bool = True,
        parameter_overrides: list[Parameter] | None = None,
        allow_undeclared_parameters: bool = False,
        automatically_declare_parameters_from_overrides: bool = False,
        enable_logger_service: bool = False,
    ) -> None:
        self._context = get_default_context() if context is None else context
        self._publishers: list[Publisher] = []
        self._subscriptions: list[Subscription] = []
        self._clients: list[Client] = []
        self._services: list[Service] = []
        self._timers: list[Timer] = []
        self._guards: list[GuardCondition] = []
        self._waitables: list[Any] = []
        self._default_callback_group = MutuallyExclusiveCallbackGroup()
        self._rate_group = ReentrantCallbackGroup()
        self._executor_ref: Any = None
        self._destroyed = False
        self._init_parameters(allow_undeclared_parameters)
        if not self._context.ok():
            raise NotInitializedException("cannot create node")
        settings = self._name(node_name, namespace or "", cli_args, use_global_arguments)
        self._participant = self._context._join()
        self._context._nodes += 1
        self._entry = NodeEntry(self._node_name, self._node_namespace)
        self._participant.nodes.append(self._entry)
        self._announcing = False
        self._logger = get_logger(self._logger_name())
        self._clock = ROSClock()
        if enable_rosout and all(s.rosout for s in settings):
            _rosout.open_for(self)
        self._parameter_event_publisher = self._make_parameter_events()
        self._parameter_overrides = self._overrides(settings)
        if parameter_overrides is not None:
            self._parameter_overrides.update({p.name: p for p in parameter_overrides})
        self._start(
            automatically_declare_parameters_from_overrides,
            start_parameter_services,
            enable_logger_service,
        )
        self._announcing = True
        self._participant.announce()

    def _name(
        self, name: str, namespace: str, cli_args: list[str] | None, use_global: bool
    ) -> list[arguments.Arguments]:
        """Work out the node's names from its arguments and the command lines."""
        validate_node_name(name)
        namespace = namespace if namespace.startswith("/") else f"/{namespace}"
        validate_namespace(namespace)
        settings = []
        if cli_args:
            try:
                settings.append(arguments.parse(["--ros-args", *cli_args]))
            except arguments.UnknownArguments as error:
                raise UnknownROSArgsError(str(error)) from None
            except ValueError as error:
                raise RCLInvalidROSArgsError(f"error parsing node arguments: {error}") from None
        if use_global:
            settings.append(self._context._arguments)
        # The node's own arguments come before the process's.
        self._rules = [rule for s in settings for rule in s.remaps]
        self._node_namespace = remapping.renamed_namespace(self._rules, name, namespace)
        self._node_name = remapping.renamed_node(self._rules, name)
        return settings

    def _logger_name(self) -> str:
        full = self.get_fully_qualified_name()
        return full[1:].replace("/", ".")

    def _make_parameter_events(self) -> Publisher:
        from rcl_interfaces.msg import ParameterEvent

        return self.create_publisher(
            ParameterEvent, "/parameter_events", qos_profile_parameter_events
        )

    def _overrides(self, settings: list[arguments.Arguments]) -> dict[str, Parameter]:
        """Return the values that command lines give to this node's parameters."""
        full = self.get_fully_qualified_name()
        found: dict[str, Parameter] = {}
        for setting in reversed(settings):  # the node's own arguments win
            for pattern, name, value in setting.parameters:
                if parameterfiles.matches(pattern, full):
                    found[name] = Parameter(name, value=value)
        return found

    def _start(self, declare_all: bool, parameter_services: bool, logger_services: bool) -> None:
        from rclpy.logging_service import LoggingService
        from rclpy.parameter_service import ParameterService
        from rclpy.time_source import TimeSource
        from rclpy.type_description_service import TypeDescriptionService

        if declare_all:
            overrides = self._parameter_overrides
            self.declare_parameters(
                "", [(n, p.value) for n, p in overrides.items()], ignore_override=True
            )
        self._time_source = TimeSource(node=self)
        self._time_source.attach_clock(self._clock)
        if parameter_services:
            self._parameter_service = ParameterService(self)
        if logger_services:
            self._logger_service = LoggingService(self)
        self._type_description_service = TypeDescriptionService(self)

    # What the node has -------------------------------------------------------------------

    @property
    def publishers(self) -> Iterator[Publisher]:
        """The publishers of this node."""
        yield from self._publishers

    @property
    def subscriptions(self) -> Iterator[Subscription]:
        """The subscriptions of this node."""
        yield from self._subscriptions

    @property
    def clients(self) -> Iterator[Client]:
        """The clients of this node."""
        yield from self._clients

    @property
    def services(self) -> Iterator[Service]:
        """The services of this node."""
        yield from self._services

    @property
    def timers(self) -> Iterator[Timer]:
        """The timers of this node."""
        yield from self._timers

    @property
    def guards(self) -> Iterator[GuardCondition]:
        """The guard conditions of this node."""
        yield from self._guards

    @property
    def waitables(self) -> Iterator[Any]:
        """What else of this node the executor runs."""
        yield from self._waitables

    def _entities(self) -> list[Any]:
        return [
            *self._timers,
            *self._subscriptions,
            *self._guards,
            *self._clients,
            *self._services,
            *self._waitables,
        ]

    @property
    def executor(self) -> Any:
        """The executor the node is in, ``None`` if it is in none."""
        return self._executor_ref() if self._executor_ref else None

    @executor.setter
    def executor(self, new_executor: Any) -> None:
        current = self.executor
        if current is new_executor:
            return
        if current is not None:
            current.remove_node(self)
        if new_executor is None:
            self._executor_ref = None
        else:
            self._executor_ref = weakref.ref(new_executor)
            new_executor.add_node(self)

    @property
    def context(self) -> Context:
        """The context."""
        return self._context

    @property
    def default_callback_group(self) -> CallbackGroup:
        """The group of callbacks that are given none; it runs one at a time."""
        return self._default_callback_group

    @property
    def handle(self) -> Node:
        """The node itself; there is no compiled part."""
        if self._destroyed:
            raise InvalidHandle("cannot use Destroyable because destruction was requested")
        return self

    @handle.setter
    def handle(self, value: Any) -> None:
        raise AttributeError("handle cannot be modified after node creation")

    def __enter__(self) -> Node:
        return self

    def __exit__(self, *exc: Any) -> None:
        if not self._destroyed:
            self.destroy_node()

    def get_name(self) -> str:
        """Return the node's name."""
        return self.handle._node_name

    def get_namespace(self) -> str:
        """Return the node's namespace."""
        return self.handle._node_namespace

    def get_fully_qualified_name(self) -> str:
        """Return the node's name with its namespace."""
        return f"{self._node_namespace.rstrip('/')}/{self._node_name}"

    def get_clock(self) -> Clock:
        """Return the node's clock, which shows simulated time if ``use_sim_time`` is set."""
        return self._clock

    def get_logger(self) -> Any:
        """Return the node's logger."""
        return self._logger

    def resolve_topic_name(self, topic: str, *, only_expand: bool = False) -> str:
        """Return the full name of a topic, remapped unless ``only_expand``."""
        return self._resolve(topic, "topic", only_expand)

    def resolve_service_name(self, service: str, *, only_expand: bool = False) -> str:
        """Return the full name of a service, remapped unless ``only_expand``."""
        return self._resolve(service, "service", only_expand)

    def _resolve(self, name: str, kind: str, only_expand: bool = False) -> str:
        is_service = kind == "service"
        node, namespace = self.get_name(), self.get_namespace()
        validate_topic_name(name, is_service=is_service)
        full = remapping.expand(name, node, namespace)
        if not only_expand:
            full = remapping.remap(self._rules, full, kind, node, namespace)
        validate_full_topic_name(full, is_service=is_service)
        return full

    # Making things -----------------------------------------------------------------------

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

    # Destroying things -------------------------------------------------------------------

    def _destroy(self, entity: Any, where: list[Any]) -> bool:
        if entity not in where:
            return False
        where.remove(entity)
        for handler in getattr(entity, "event_handlers", ()):
            self._waitables.remove(handler)
        entity.destroy()
        return True

    def destroy_publisher(self, publisher: Publisher) -> bool:
        """Destroy a publisher; ``False`` if it is not this node's."""
        done = self._destroy(publisher, self._publishers)
        self._endpoints_changed()
        return done

    def destroy_subscription(self, subscription: Subscription) -> bool:
        """Destroy a subscription; ``False`` if it is not this node's."""
        done = self._destroy(subscription, self._subscriptions)
        self._endpoints_changed()
        return done

    def destroy_client(self, client: Client) -> bool:
        """Destroy a client; ``False`` if it is not this node's."""
        done = self._destroy(client, self._clients)
        self._endpoints_changed()
        return done

    def destroy_service(self, service: Service) -> bool:
        """Destroy a service; ``False`` if it is not this node's."""
        done = self._destroy(service, self._services)
        self._endpoints_changed()
        return done

    def destroy_timer(self, timer: Timer) -> bool:
        """Destroy a timer; ``False`` if it is not this node's."""
        return self._destroy(timer, self._timers)

    def destroy_guard_condition(self, guard: GuardCondition) -> bool:
        """Destroy a guard condition; ``False`` if it is not this node's."""
        return self._destroy(guard, self._guards)

    def destroy_rate(self, rate: Rate) -> bool:
        """Destroy a rate; ``False`` if it is not this node's."""
        done = self.destroy_timer(rate._timer)
        rate.destroy()
        return done

    def destroy_node(self) -> None:
        """Destroy the node and everything it has."""
        if self._destroyed:
            return
        self._announcing = False
        executor = self.executor
        if executor is not None:
            executor.remove_node(self)
        _rosout.close_for(self)
        kinds: list[list[Any]] = [
            self._publishers,
            self._subscriptions,
            self._clients,
            self._services,
            self._timers,
            self._guards,
        ]
        for where in kinds:
            while where:
                self._destroy(where[0], where)
        self._destroyed = True
        self._participant.nodes.remove(self._entry)
        self._participant.announce()
        self._context._node_gone()
