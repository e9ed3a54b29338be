"""The services through which others reach a node's logger levels."""

from __future__ import annotations

from typing import Any

from rcl_interfaces.msg import LoggerLevel, SetLoggerLevelsResult
from rcl_interfaces.srv import GetLoggerLevels, SetLoggerLevels

import rclpy.logging


class LoggingService:
    """Offers ``<node>/get_logger_levels`` and ``<node>/set_logger_levels``.

    :param node: the node.
    """

    def __init__(self, node: Any) -> None:
        name = node.get_name()
        node.create_service(GetLoggerLevels, f"{name}/get_logger_levels", self._get)
        node.create_service(SetLoggerLevels, f"{name}/set_logger_levels", self._set)

    def _get(self, request: Any, response: Any) -> Any:
        response.levels = [
            LoggerLevel(name=name, level=int(rclpy.logging.get_logger_level(name)))
            for name in request.names
        ]
        return response

    def _set(self, request: Any, response: Any) -> Any:
        results = []
        for level in request.levels:
            result = SetLoggerLevelsResult(successful=True)
            try:
                rclpy.logging.set_logger_level(level.name, level.level)
            except ValueError:
                result = SetLoggerLevelsResult(successful=False, reason="Failed to set level")
            results.append(result)
        response.results = results
        return response
