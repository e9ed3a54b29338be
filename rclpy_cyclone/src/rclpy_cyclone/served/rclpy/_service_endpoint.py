"""The two DDS endpoints behind a service or a client, in rmw_cyclonedds's manner."""

from __future__ import annotations

import secrets
import struct
import time
from typing import Any

from rclpy.exceptions import InvalidHandle
from rclpy_cyclone.dds import clib, graph
from rclpy_cyclone.dds.participant import take
from rclpy_cyclone.dds.qos import Policies

_HEADER = struct.Struct("<Qq")
_CLIENT_WAIT = 0.1  # seconds a response waits for the way back to its client


class ServiceEndpoint:
    """Reader and writer of one side of a service.

    :param node: the node it is for.
    :param srv_type: class of the service.
    :param name: full name of the service.
    :param policies: policies of both endpoints.
    :param serves: whether this is the side that answers.
    """

    def __init__(
        self, node: Any, srv_type: Any, name: str, policies: Policies, *, serves: bool
    ) -> None:
        self._participant = node._participant
        self._entry = node._entry
        self._closed = False
        request = (f"rq{name}Request", f"{srv_type._ros_name}_Request")
        response = (f"rr{name}Reply", f"{srv_type._ros_name}_Response")
        inward, outward = (request, response) if serves else (response, request)
        # Ties the two together for the other side, so that it can tell when both are there.
        raw = secrets.token_bytes(16)
        identity = f"{raw[0]:2x}" + "".join(f".{b:x}" for b in raw[1:])
        data = f"{'serviceid' if serves else 'clientid'}={identity};".encode()
        self.writer = self._participant.writer(*outward, policies, data)
        self.reader = self._participant.reader(*inward, policies, False, data)
        condition = clib.blocking.dds_create_readcondition(self.reader, clib.ANY_STATE)
        self.condition = clib.check(condition, "create read condition")
        self._gids = clib.guid(self.reader), clib.guid(self.writer)
        self._entry.readers.append(self._gids[0])
        self._entry.writers.append(self._gids[1])
        self._known: set[int] = set()  # clients that are known to have their way back

    def alive(self) -> None:
        """Raise InvalidHandle if the endpoints are gone."""
        if self._closed or self._participant.closed:
            raise InvalidHandle("cannot use Destroyable because destruction was requested")

    def take(self) -> list[tuple[int, int, bytes, int]]:
        """Return what came in: identity, number, CDR data, and handle of the sender."""
        found = []
        for data, info in take(self.reader):
            if info.valid_data and len(data) >= 20:
                identity, number = _HEADER.unpack_from(data, 4)
                found.append((identity, number, data[:4] + data[20:], info.publication_handle))
        return found

    def has_server(self) -> bool:
        """Say whether a service is there with both its endpoints (asked by a client)."""
        self.alive()
        readers = graph.matched_readers(self.writer)
        writers = graph.matched_writers(self.reader)
        wanted = {r.tags["serviceid"] for r in readers if "serviceid" in r.tags}
        if not wanted:
            return bool(readers and writers)
        return any(w.tags.get("serviceid") in wanted for w in writers)

    def wait_for_client(self, sender: int) -> None:
        """Wait until the client that sent a request can hear the response, or is gone."""
        if sender in self._known:
            return
        end = time.monotonic() + _CLIENT_WAIT
        while True:
            writer = graph.matched_writer(self.reader, sender)
            if writer is None or "clientid" not in writer.tags:
                return
            client = writer.tags["clientid"]
            if any(r.tags.get("clientid") == client for r in graph.matched_readers(self.writer)):
                self._known.add(sender)
                return
            if time.monotonic() >= end:
                return
            time.sleep(0.002)

    def close(self) -> None:
        """Delete both endpoints."""
        self._closed = True
        if self._gids[0] in self._entry.readers:
            self._entry.readers.remove(self._gids[0])
            self._entry.writers.remove(self._gids[1])
        if not self._participant.closed:
            clib.delete(self.reader)
            clib.delete(self.writer)
