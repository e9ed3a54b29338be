"""The service ``<node>/get_type_description``."""

from __future__ import annotations

from typing import Any

from rclpy.parameter import Parameter
from rclpy.qos import qos_profile_services_default

START_TYPE_DESCRIPTION_SERVICE_PARAM = "start_type_description_service"


class TypeDescriptionService:
    """Describes the types a node uses, if its parameter ``start_type_description_service`` is
    true.

    :param node: the node.
    """

    def __init__(self, node: Any) -> None:
        from rcl_interfaces.msg import ParameterDescriptor

        name = START_TYPE_DESCRIPTION_SERVICE_PARAM
        if not node.has_parameter(name):
            descriptor = ParameterDescriptor(
                name=name,
                type=Parameter.Type.BOOL.value,
                description="If enabled, start the ~/get_type_description service.",
                read_only=True,
            )
            node.declare_parameter(name, True, descriptor)
        parameter = node.get_parameter(name)
        self.service_name = f"{node.get_name()}/get_type_description"
        self.enabled = False
        if parameter.type_ == Parameter.Type.BOOL:
            self.enabled = parameter.value
        else:
            node.get_logger().error(
                f"Invalid type for parameter '{name}' {parameter.type_!r} should be bool"
            )
        if self.enabled:
            from type_description_interfaces.srv import GetTypeDescription

            node.create_service(
                GetTypeDescription,
                self.service_name,
                self._describe,
                qos_profile=qos_profile_services_default,
            )

    def _describe(self, request: Any, response: Any) -> Any:
        from rclpy_cyclone.types import description, store

        if request.type_name not in store.names():
            response.failure_reason = f"Type '{request.type_name}' is not currently in use"
            return response
        if request.type_hash and request.type_hash != store.type_hash(request.type_name):
            response.failure_reason = f"Type '{request.type_name}' has another hash"
            return response
        response.successful = True
        response.type_description = description.describe(request.type_name)
        return response
