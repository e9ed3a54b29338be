"""Services."""

from __future__ import annotations

import inspect
import struct
from collections import deque
from collections.abc import Callable
from typing import Any, NamedTuple

from rclpy._ready import Ready
from rclpy._service_endpoint import ServiceEndpoint
from rclpy_cyclone.dds.participant import write
from rclpy_cyclone.dds.qos import Policies
from rclpy_cyclone.types import cdr

_HEADER = struct.Struct("<Qq")


class RequestId(NamedTuple):
    """Who asked, and the number the answer has to bear."""

    writer_guid: int
    sequence_number: int
    sender: int  # handle of the client's writer


class Service(Ready):
    """Answers requests. Nodes offer ``create_service`` for this."""

    def __init__(
        self,
        node: Any,
        srv_type: Any,
        srv_name: str,
        callback: Callable[[Any, Any], Any],
        callback_group: Any,
        qos_profile: Any,
        policies: Policies,
        full_name: str,
    ) -> None:
        super().__init__()
        self.srv_type = srv_type
        self.srv_name = srv_name
        self.callback = callback
        self.callback_group = callback_group
        self.qos_profile = qos_profile
        self._full_name = full_name
        self._end = ServiceEndpoint(node, srv_type, full_name, policies, serves=True)
        self._waits.append((self._end.condition, self._drain))
        self._requests: deque[tuple[RequestId, bytes]] = deque()

    def _drain(self) -> None:
        for identity, number, data, sender in self._end.take():
            self._requests.append((RequestId(identity, number, sender), data))
        if self._requests:
            self._ready()

    def _pending(self) -> bool:
        return bool(self._requests)

    def _take(self) -> tuple[Any, tuple[Any, ...]] | None:
        if not self._requests:
            return None
        request_id, data = self._requests.popleft()
        request = cdr.deserialise(data, self.srv_type.Request)
        if inspect.iscoroutinefunction(self.callback):
            return self._serve_later, (request_id, request)
        return self._serve, (request_id, request)

    def _serve(self, request_id: RequestId, request: Any) -> None:
        self.send_response(self.callback(request, self.srv_type.Response()), request_id)

    async def _serve_later(self, request_id: RequestId, request: Any) -> None:
        response = await self.callback(request, self.srv_type.Response())
        self.send_response(response, request_id)

    def send_response(self, response: Any, header: Any) -> None:
        """Send a response.

        :param response: the response.
        :param header: identity of the request.
        :raises TypeError: if an argument is of the wrong type.
        """
        if not isinstance(response, self.srv_type.Response):
            raise TypeError()
        if not isinstance(header, RequestId):
            raise TypeError()
        self._end.alive()
        data = cdr.serialise(response)
        self._end.wait_for_client(header.sender)
        head = _HEADER.pack(header.writer_guid, header.sequence_number)
        write(self._end.writer, bytes(data[:4]) + head + bytes(data[4:]))

    @property
    def service_name(self) -> str:
        """Full name of the service, remapped."""
        self._end.alive()
        return self._full_name

    def configure_introspection(self, clock: Any, qos_profile: Any, state: Any) -> None:
        """Service introspection is not offered."""
        raise NotImplementedError("service introspection is not offered by rclpy_cyclone")

    def destroy(self) -> None:
        """Release the service; nodes offer ``destroy_service`` for this."""
        if not self._destroyed:
            super().destroy()
            self._end.close()
