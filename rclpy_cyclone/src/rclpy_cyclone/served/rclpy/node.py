"""Nodes."""

from __future__ import annotations

import weakref
from collections.abc import Iterator
from typing import Any

from rclpy import _rosout
from rclpy._node_entities import NodeEntities
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
from rclpy.context import Context
from rclpy.exceptions import InvalidHandle, NotInitializedException
from rclpy.guard_condition import GuardCondition
from rclpy.logging import get_logger
from rclpy.parameter import Parameter
from rclpy.publisher import Publisher
from rclpy.qos import qos_profile_parameter_events
from rclpy.service import Service
from rclpy.subscription import Subscription
from rclpy.time_source import TimeSource
from rclpy.timer import Rate, Timer
from rclpy.utilities import get_default_context
from rclpy.validate_full_topic_name import validate_full_topic_name
from rclpy.validate_namespace import validate_namespace
from rclpy.validate_node_name import validate_node_name
from rclpy.validate_topic_name import validate_topic_name
from rclpy_cyclone import arguments, parameterfiles, remapping
from rclpy_cyclone.dds.participant import NodeEntry


class Node(NodeEntities, NodeParameters, NodeGraph):
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
        self._init_entities()
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
        if unknown := remapping.unknown_substitution(name):
            raise ValueError(f"topic name '{name}' is invalid: unknown substitution: {unknown}")
        full = remapping.expand(name, node, namespace)
        if not only_expand:
            full = remapping.remap(self._rules, full, kind, node, namespace)
        validate_full_topic_name(full, is_service=is_service)
        return full

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
