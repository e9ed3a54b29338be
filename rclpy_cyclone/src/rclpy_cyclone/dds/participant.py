"""The one DDS participant of a context, and what it tells the graph about its nodes."""

from __future__ import annotations

import atexit
import ctypes as ct
import threading
import weakref
from typing import Any

from cyclonedds import _clayer

from rclpy_cyclone.dds import domain, qos, typeinfo
from rclpy_cyclone.dds.clib import (
    ANY_STATE,
    TAKE,
    WRITE,
    blocking,
    check,
    delete,
    guid,
)
from rclpy_cyclone.types import cdr, classes

_DISCOVERY = "rmw_dds_common/msg/ParticipantEntitiesInfo"
_living: weakref.WeakSet[Participant] = weakref.WeakSet()


class Participant:
    """A DDS participant with its nodes.

    :param domain_id: number of the DDS domain.
    :param enclave: security enclave to announce (ROS 2's default is ``/``).
    """

    def __init__(self, domain_id: int, enclave: str = "/") -> None:
        self.domain_id = domain_id
        self.lock = threading.RLock()
        self.topics: dict[str, tuple[int, Any]] = {}  # name -> (entity, type)
        self.nodes: list[NodeEntry] = []
        self.local_topics: dict[str, Any] = {}  # exchange within the process, see intra.py
        domain.acquire(domain_id)
        self.closed = False
        handle = qos.c_qos(qos.participant_qos(f"enclave={enclave};".encode()))
        try:
            self.entity = check(
                blocking.dds_create_participant(domain_id, handle, None),
                f"create DDS participant in domain {domain_id}",
            )
        except Exception:
            domain.release(domain_id)
            raise
        finally:
            qos.free(handle)
        self.guid = guid(self.entity)
        self._info_type = classes.message_class(_DISCOVERY)
        policies = qos.Policies(depth=1, transient_local=True)
        self._info_writer = self.writer("ros_discovery_info", _DISCOVERY, policies)
        policies = qos.Policies(keep_all=True, transient_local=True)
        self._info_reader = self.reader("ros_discovery_info", _DISCOVERY, policies, True)
        self.others: dict[bytes, Any] = {}  # participant gid -> what it told of its nodes
        _living.add(self)

    def topic(self, name: str, typename: str) -> int:
        """Return the topic entity of a DDS topic name, made on first use.

        :raises DdsError: if the topic exists in this participant with another type.
        """
        with self.lock:
            key = f"{name}\n{typename}"
            if key not in self.topics:
                kind = typeinfo.topic_type(typename)
                made = _clayer.ddspy_topic_create(self.entity, name, kind, None, None)
                self.topics[key] = (check(made, f"create topic {name}"), kind)
            return self.topics[key][0]

    def writer(
        self, topic: str, typename: str, policies: qos.Policies, user_data: bytes = b""
    ) -> int:
        """Return a new DDS writer."""
        make = blocking.dds_create_writer
        return self._endpoint(make, topic, typename, policies, False, user_data)

    def reader(
        self,
        topic: str,
        typename: str,
        policies: qos.Policies,
        ignore_local: bool,
        user_data: bytes = b"",
    ) -> int:
        """Return a new DDS reader, which may be deaf to this participant's own writers."""
        make = blocking.dds_create_reader
        return self._endpoint(make, topic, typename, policies, ignore_local, user_data)

    def _endpoint(
        self,
        make: Any,
        topic: str,
        typename: str,
        policies: qos.Policies,
        ignore_local: bool,
        user_data: bytes,
    ) -> int:
        topic_entity = self.topic(topic, typename)
        data = user_data + typeinfo.user_data(typename)
        handle = qos.c_qos(qos.endpoint_qos(policies, data, ignore_local))
        try:
            return check(make(self.entity, topic_entity, handle, None), f"endpoint of {topic}")
        finally:
            qos.free(handle)

    def announce(self) -> None:
        """Tell the graph which nodes there are, and which endpoints they have."""
        with self.lock:
            if self.closed:
                return
            gid_class = classes.message_class("rmw_dds_common/msg/Gid")
            entry_class = classes.message_class("rmw_dds_common/msg/NodeEntitiesInfo")

            def gid(raw: bytes) -> Any:
                return gid_class(data=list(raw))

            info = self._info_type(gid=gid(self.guid))
            info.node_entities_info_seq = [
                entry_class(
                    node_namespace=node.namespace,
                    node_name=node.name,
                    reader_gid_seq=[gid(g) for g in node.readers],
                    writer_gid_seq=[gid(g) for g in node.writers],
                )
                for node in self.nodes
            ]
            write(self._info_writer, cdr.serialise(info))

    def hear(self) -> dict[bytes, Any]:
        """Return what every other participant told of its nodes, by participant gid."""
        with self.lock:
            for data, info in take(self._info_reader):
                if info.valid_data:
                    told = cdr.deserialise(data, self._info_type)
                    self.others[bytes(told.gid.data)] = told
            return self.others

    @property
    def info_reader(self) -> int:
        """The reader of other participants' announcements."""
        return self._info_reader

    def close(self) -> None:
        """Leave the graph: delete the participant and everything in it."""
        with self.lock:
            if self.closed:
                return
            self.closed = True
        delete(self.entity)
        domain.release(self.domain_id)


class NodeEntry:
    """A node as the graph sees it: its name and the gids of its endpoints."""

    def __init__(self, name: str, namespace: str) -> None:
        self.name = name
        self.namespace = namespace
        self.readers: list[bytes] = []
        self.writers: list[bytes] = []


def write(writer: int, data: bytes | bytearray) -> None:
    """Write a serialised sample, padded as the wire wants it.

    :raises DdsError: if Cyclone refuses it.
    """
    if len(data) & 3:
        data = bytes(data) + bytes(-len(data) & 3)
    result = WRITE(writer, data)
    if result < 0:
        check(result, "write")


def take(reader: int, most: int = 4096) -> list[tuple[bytes, Any]]:
    """Return what a reader holds as ``(data, sample info)``, oldest first."""
    taken = TAKE(reader, ANY_STATE, most)
    if taken.__class__ is int:
        check(taken, "take")
        return []
    return taken


def matched_readers(writer: int) -> int:
    """Return how many readers a writer is matched with."""
    return blocking.dds_get_matched_subscriptions(writer, None, 0)


def instance_handle(entity: int) -> int:
    """Return the handle under which an entity appears in others' match lists."""
    value = ct.c_uint64()
    check(blocking.dds_get_instance_handle(entity, ct.byref(value)), "get instance handle")
    return value.value


@atexit.register
def _close_all() -> None:
    for participant in list(_living):
        participant.close()
