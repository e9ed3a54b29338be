"""Clients of services."""

from __future__ import annotations

import random
import struct
import threading
import time
from typing import Any

from rclpy._ready import Ready
from rclpy._service_endpoint import ServiceEndpoint
from rclpy.task import Future
from rclpy_cyclone.dds.participant import write
from rclpy_cyclone.dds.qos import Policies
from rclpy_cyclone.types import cdr

_HEADER = struct.Struct("<Qq")


class Client(Ready):
    """Calls a service. Nodes offer ``create_client`` for this."""

    def __init__(
        self,
        node: Any,
        srv_type: Any,
        srv_name: str,
        qos_profile: Any,
        callback_group: Any,
        policies: Policies,
        full_name: str,
    ) -> None:
        super().__init__()
        self.context = node.context
        self.srv_type = srv_type
        self.srv_name = srv_name
        self.qos_profile = qos_profile
        self.callback_group = callback_group
        self._full_name = full_name
        self._pending_requests: dict[int, Future] = {}
        self._lock = threading.Lock()
        self._sequence = 0
        self._identity = random.getrandbits(64)  # responses to others are not for us
        self._end = ServiceEndpoint(node, srv_type, full_name, policies, serves=False)
        self._waits.append((self._end.condition, self._drain))
        self._responses: list[tuple[int, bytes]] = []

    def _drain(self) -> None:
        for identity, number, data, _ in self._end.take():
            if identity == self._identity:
                self._responses.append((number, data))
        if self._responses:
            self._ready()

    def _pending(self) -> bool:
        return bool(self._responses)

    def _take(self) -> tuple[Any, tuple[Any, ...]] | None:
        if not self._responses:
            return None
        number, data = self._responses.pop(0)
        return self._answer, (number, data)

    def _answer(self, number: int, data: bytes) -> None:
        with self._lock:
            future = self._pending_requests.get(number)
        if future is None:  # given up meanwhile
            return
        future._set_executor(self._executor)
        future.set_result(cdr.deserialise(data, self.srv_type.Response))

    def call(self, request: Any, timeout_sec: float | None = None) -> Any:
        """Call the service and wait, while an executor spins in another thread.

        :param request: the request.
        :param timeout_sec: how long to wait; for ever if ``None``.
        :return: the response, ``None`` on a time out.
        :raises TypeError: if the request is of the wrong type.
        """
        event = threading.Event()
        future = self.call_async(request)
        future.add_done_callback(lambda _: event.set())
        if not future.done() and not event.wait(timeout_sec):
            self.remove_pending_request(future)
        if future.exception() is not None:
            raise future.exception()
        return future.result()

    def call_async(self, request: Any) -> Future:
        """Call the service without waiting.

        :param request: the request.
        :return: a future of the response.
        :raises TypeError: if the request is of the wrong type.
        """
        if not isinstance(request, self.srv_type.Request):
            raise TypeError()
        self._end.alive()
        data = cdr.serialise(request)
        future = Future()
        with self._lock:
            self._sequence += 1
            number = self._sequence
            self._pending_requests[number] = future
            future.add_done_callback(self.remove_pending_request)
            head = _HEADER.pack(self._identity, number)
            write(self._end.writer, bytes(data[:4]) + head + bytes(data[4:]))
        return future

    def get_pending_request(self, sequence_number: int) -> Future:
        """Return the future of a request by its number.

        :raises KeyError: if there is none.
        """
        with self._lock:
            return self._pending_requests[sequence_number]

    def remove_pending_request(self, future: Future) -> None:
        """Forget a request: its response will be dropped."""
        with self._lock:
            for number, pending in self._pending_requests.items():
                if pending is future:
                    del self._pending_requests[number]
                    break

    def service_is_ready(self) -> bool:
        """Say whether there is a service to call."""
        return self._end.has_server()

    def wait_for_service(self, timeout_sec: float | None = None) -> bool:
        """Wait until there is a service to call.

        :param timeout_sec: how long to wait; for ever if ``None``.
        :return: whether there is one.
        """
        end = None if timeout_sec is None else time.monotonic() + timeout_sec
        pause = 0.005
        while self.context.ok() and not self.service_is_ready():
            left = pause if end is None else min(pause, end - time.monotonic())
            if left <= 0:
                break
            time.sleep(left)
            pause = min(pause * 1.5, 0.1)
        return self.service_is_ready()

    @property
    def service_name(self) -> str:
        """Full name of the service, remapped."""
        self._end.alive()
        return self._full_name

    def configure_introspection(self, clock: Any, qos_profile: Any, state: Any) -> None:
        """Service introspection is not offered."""
        raise NotImplementedError("service introspection is not offered by rclpy_cyclone")

    def destroy(self) -> None:
        """Release the client; nodes offer ``destroy_client`` for this."""
        if not self._destroyed:
            super().destroy()
            self._end.close()
