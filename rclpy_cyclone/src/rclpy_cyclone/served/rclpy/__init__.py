"""rclpy: the ROS 2 client library for Python, here over Cyclone DDS from PyPI.

Initialise with :func:`init`, create nodes, run their callbacks with :func:`spin` and its
relatives, and end with :func:`shutdown`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rclpy.context import Context
from rclpy.parameter import Parameter
from rclpy.signals import (
    SignalHandlerOptions,
    install_signal_handlers,
    uninstall_signal_handlers,
)
from rclpy.task import Future
from rclpy.utilities import (  # noqa: F401
    get_default_context,
    get_rmw_implementation_identifier,
    ok,
    try_shutdown,
)
from rclpy.utilities import shutdown as _shutdown

if TYPE_CHECKING:
    from rclpy.executors import Executor
    from rclpy.node import Node


class InitContextManager:
    """What :func:`init` returns: leaving it shuts the context down."""

    def __init__(self, context: Context, options: SignalHandlerOptions) -> None:
        self.context = context
        self.installed_signal_handlers = options != SignalHandlerOptions.NO

    def __enter__(self) -> InitContextManager:
        return self

    def __exit__(self, *exc: Any) -> None:
        if self.context is get_default_context():
            try_shutdown()
        else:
            self.context.try_shutdown()
        if self.installed_signal_handlers:
            uninstall_signal_handlers()


def init(
    *,
    args: list[str] | None = None,
    context: Context | None = None,
    domain_id: int | None = None,
    signal_handler_options: SignalHandlerOptions | None = None,
) -> InitContextManager:
    """Initialise a context.

    :param args: command line, ``sys.argv`` by default.
    :param context: the context, by default the default one.
    :param domain_id: DDS domain, by default that of ``ROS_DOMAIN_ID``.
    :param signal_handler_options: which signals shut contexts down; by default all for the
        default context, none for others.
    :return: a context manager that shuts the context down.
    """
    default = get_default_context()
    context = default if context is None else context
    if signal_handler_options is None:
        signal_handler_options = (
            SignalHandlerOptions.ALL if context is default else SignalHandlerOptions.NO
        )
    context.init(args, domain_id=domain_id)
    install_signal_handlers(signal_handler_options)
    return InitContextManager(context, signal_handler_options)


__executor: Any = None


def get_global_executor() -> Executor:
    """Return the executor that :func:`spin` uses if it is given none."""
    global __executor
    if __executor is not None and __executor.context is not get_default_context():
        __executor = None  # it is of a context that a signal ended
    if __executor is None:
        from rclpy.executors import SingleThreadedExecutor

        executor = __executor = SingleThreadedExecutor()

        def reset() -> None:
            global __executor
            executor.shutdown()
            if __executor is executor:
                __executor = None

        get_default_context().on_shutdown(reset)
        return executor
    return __executor


def shutdown(*, context: Context | None = None, uninstall_handlers: bool | None = None) -> None:
    """Shut a context down.

    :param context: the context, by default the default one.
    :param uninstall_handlers: whether to stop listening to signals; by default if it is the
        default context.
    """
    is_default = context is None or context is get_default_context()
    _shutdown(context=context)
    if uninstall_handlers or (uninstall_handlers is None and is_default):
        uninstall_signal_handlers()


def create_node(
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
) -> Node:
    """Return a new node; the arguments are those of :class:`.Node`."""
    from rclpy.node import Node

    return Node(
        node_name,
        context=context,
        cli_args=cli_args,
        namespace=namespace,
        use_global_arguments=use_global_arguments,
        enable_rosout=enable_rosout,
        start_parameter_services=start_parameter_services,
        parameter_overrides=parameter_overrides,
        allow_undeclared_parameters=allow_undeclared_parameters,
        automatically_declare_parameters_from_overrides=(
            automatically_declare_parameters_from_overrides
        ),
        enable_logger_service=enable_logger_service,
    )


def spin_once(
    node: Node, *, executor: Executor | None = None, timeout_sec: float | None = None
) -> None:
    """Run one callback, waiting for it if need be.

    :param node: taken into the executor meanwhile.
    :param executor: by default the global one.
    :param timeout_sec: how long to wait; for ever if ``None`` or negative.
    """
    executor = get_global_executor() if executor is None else executor
    try:
        executor.add_node(node)
        executor.spin_once(timeout_sec=timeout_sec)
    finally:
        executor.remove_node(node)


def spin(node: Node, executor: Executor | None = None) -> None:
    """Run callbacks until the context is shut down.

    :param node: taken into the executor meanwhile.
    :param executor: by default the global one.
    :raises ExternalShutdownException: if the shutdown came while waiting.
    """
    executor = get_global_executor() if executor is None else executor
    try:
        executor.add_node(node)
        while executor.context.ok() and not executor._is_shutdown:
            executor.spin()
    finally:
        executor.remove_node(node)


def spin_until_future_complete(
    node: Node,
    future: Future,
    executor: Executor | None = None,
    timeout_sec: float | None = None,
) -> None:
    """Run callbacks until a future is done, the time out has come, or the context is shut down.

    :param node: taken into the executor meanwhile.
    :param future: the future.
    :param executor: by default the global one.
    :param timeout_sec: how long to spin; for ever if ``None`` or negative.
    """
    executor = get_global_executor() if executor is None else executor
    added = False
    try:
        added = executor.add_node(node)
        executor.spin_until_future_complete(future, timeout_sec)
    finally:
        if added:
            executor.remove_node(node)
