"""Parameters of other nodes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from rcl_interfaces.srv import (
    DescribeParameters,
    GetParameters,
    GetParameterTypes,
    ListParameters,
    SetParameters,
    SetParametersAtomically,
)

from rclpy.parameter import Parameter, parameter_dict_from_yaml_file
from rclpy.qos import QoSProfile, qos_profile_services_default
from rclpy.task import Future

_SERVICES = {
    "get_parameters": GetParameters,
    "set_parameters": SetParameters,
    "set_parameters_atomically": SetParametersAtomically,
    "list_parameters": ListParameters,
    "describe_parameters": DescribeParameters,
    "get_parameter_types": GetParameterTypes,
}


class AsyncParameterClient:
    """Reaches the parameters of another node through its services.

    :param node: node to call from.
    :param remote_node_name: name of the other node.
    :param qos_profile: profile of the clients.
    :param callback_group: group in which responses are handled.
    """

    def __init__(
        self,
        node: Any,
        remote_node_name: str,
        qos_profile: QoSProfile = qos_profile_services_default,
        callback_group: Any = None,
    ) -> None:
        self.node = node
        self.remote_node_name = remote_node_name
        self._clients = {
            name: node.create_client(
                srv_type,
                f"{remote_node_name}/{name}",
                qos_profile=qos_profile,
                callback_group=callback_group,
            )
            for name, srv_type in _SERVICES.items()
        }

    def services_are_ready(self) -> bool:
        """Say whether all the services are there."""
        return all(client.service_is_ready() for client in self._clients.values())

    def wait_for_services(self, timeout_sec: float | None = None) -> bool:
        """Wait until all the services are there.

        :param timeout_sec: how long to wait for all together; for ever if ``None``.
        """
        import time

        end = None if timeout_sec is None else time.monotonic() + timeout_sec
        for client in self._clients.values():
            left = None if end is None else max(0.0, end - time.monotonic())
            if not client.wait_for_service(left):
                return False
        return True

    def _call(self, name: str, callback: Callable[[Future], None] | None, **values: Any) -> Future:
        future = self._clients[name].call_async(_SERVICES[name].Request(**values))
        if callback is not None:
            future.add_done_callback(callback)
        return future

    def list_parameters(
        self,
        prefixes: list[str] | None = None,
        depth: int | None = None,
        callback: Callable[[Future], None] | None = None,
    ) -> Future:
        """Ask for the names below some prefixes, ``depth`` levels deep."""
        return self._call("list_parameters", callback, prefixes=prefixes or [], depth=depth or 0)

    def get_parameters(
        self, names: list[str], callback: Callable[[Future], None] | None = None
    ) -> Future:
        """Ask for the values of parameters."""
        return self._call("get_parameters", callback, names=names)

    def set_parameters(
        self, parameters: Sequence[Any], callback: Callable[[Future], None] | None = None
    ) -> Future:
        """Set parameters one by one; they are :class:`.Parameter` or its message."""
        return self._call("set_parameters", callback, parameters=_messages(parameters))

    def set_parameters_atomically(
        self, parameters: Sequence[Any], callback: Callable[[Future], None] | None = None
    ) -> Future:
        """Set all parameters or none; they are :class:`.Parameter` or its message."""
        messages = _messages(parameters)
        return self._call("set_parameters_atomically", callback, parameters=messages)

    def describe_parameters(
        self, names: list[str], callback: Callable[[Future], None] | None = None
    ) -> Future:
        """Ask for the descriptors of parameters."""
        return self._call("describe_parameters", callback, names=names)

    def get_parameter_types(
        self, names: list[str], callback: Callable[[Future], None] | None = None
    ) -> Future:
        """Ask for the types of parameters."""
        return self._call("get_parameter_types", callback, names=names)

    def delete_parameters(
        self, names: list[str], callback: Callable[[Future], None] | None = None
    ) -> Future:
        """Unset parameters, which undeclares those of dynamic type."""
        return self.set_parameters([Parameter(name) for name in names], callback)

    def load_parameter_file(
        self,
        parameter_file: str,
        use_wildcard: bool = False,
        callback: Callable[[Future], None] | None = None,
    ) -> Future:
        """Set the parameters a file holds for the other node."""
        found = parameter_dict_from_yaml_file(
            parameter_file, use_wildcard, target_nodes=[self.remote_node_name]
        )
        return self.set_parameters(list(found.values()), callback)

    def load_parameter_file_atomically(
        self,
        parameter_file: str,
        use_wildcard: bool = False,
        callback: Callable[[Future], None] | None = None,
    ) -> Future:
        """Set all the parameters a file holds for the other node, or none."""
        found = parameter_dict_from_yaml_file(
            parameter_file, use_wildcard, target_nodes=[self.remote_node_name]
        )
        return self.set_parameters_atomically(list(found.values()), callback)


def _messages(parameters: Sequence[Any]) -> list[Any]:
    return [p.to_parameter_msg() if isinstance(p, Parameter) else p for p in parameters]
