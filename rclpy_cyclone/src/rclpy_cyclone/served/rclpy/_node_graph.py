"""What a node can tell about the graph."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from rclpy._rclpy_pybind11 import NodeNameNonExistentError
from rclpy.duration import Duration
from rclpy.expand_topic_name import expand_topic_name
from rclpy.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    LivelinessPolicy,
    QoSProfile,
    ReliabilityPolicy,
)
from rclpy.topic_endpoint_info import TopicEndpointInfo, TopicEndpointTypeEnum
from rclpy.type_hash import TypeHash
from rclpy.validate_full_topic_name import validate_full_topic_name
from rclpy_cyclone import remapping
from rclpy_cyclone.dds import graph
from rclpy_cyclone.types import store

NamesAndTypes = list[tuple[str, list[str]]]


class NodeGraph:
    """Part of :class:`.Node`: nodes, topics and services in the domain."""

    _participant: Any
    _rules: list[remapping.Rule]
    get_name: Callable[[], str]
    get_namespace: Callable[[], str]

    def _nodes_seen(self) -> list[tuple[str, str, str, set[bytes], set[bytes]]]:
        """Return name, namespace, enclave, readers and writers of every node."""
        here = self._participant
        found = [(n.name, n.namespace, "/", set(n.readers), set(n.writers)) for n in here.nodes]
        present = graph.participants(here)
        for gid, told in here.hear().items():
            if gid == here.guid or gid not in present:
                continue
            enclave = present[gid].get("enclave", "/")
            for node in told.node_entities_info_seq:
                readers = {bytes(g.data) for g in node.reader_gid_seq}
                writers = {bytes(g.data) for g in node.writer_gid_seq}
                found.append((node.node_name, node.node_namespace, enclave, readers, writers))
        return found

    def get_node_names_and_namespaces_with_enclaves(self) -> list[tuple[str, str, str]]:
        """Return name, namespace and enclave of all nodes."""
        return [(n[0], n[1], n[2]) for n in self._nodes_seen()]

    def get_node_names_and_namespaces(self) -> list[tuple[str, str]]:
        """Return name and namespace of all nodes."""
        return [(n[0], n[1]) for n in self._nodes_seen()]

    def get_node_names(self) -> list[str]:
        """Return the names of all nodes."""
        return [n[0] for n in self._nodes_seen()]

    def get_fully_qualified_node_names(self) -> list[str]:
        """Return the names of all nodes with their namespaces."""
        return [f"{ns.rstrip('/')}/{name}" for name, ns in self.get_node_names_and_namespaces()]

    def get_topic_names_and_types(self, no_demangle: bool = False) -> NamesAndTypes:
        """Return all topics with their types.

        :param no_demangle: whether to give the names that DDS uses, of all topics.
        """
        here = self._participant
        return _names(graph.publishers(here) + graph.subscribers(here), _topic(no_demangle))

    def get_service_names_and_types(self) -> NamesAndTypes:
        """Return all services with their types."""
        here = self._participant
        return _names(graph.publishers(here) + graph.subscribers(here), _service)

    def _by_node(
        self, name: str, namespace: str, writers: bool, read: Callable[[Any], Any]
    ) -> NamesAndTypes:
        here = self._participant
        for node in self._nodes_seen():
            if node[0] == name and node[1] == namespace:
                mine = node[4] if writers else node[3]
                everything = graph.publishers(here) if writers else graph.subscribers(here)
                return _names([e for e in everything if e.gid in mine], read)
        raise NodeNameNonExistentError(
            f"cannot get names and types: node '{name}' in namespace '{namespace}' not found"
        )

    def get_publisher_names_and_types_by_node(
        self, node_name: str, node_namespace: str, no_demangle: bool = False
    ) -> NamesAndTypes:
        """Return the topics a node publishes, with their types.

        :raises NodeNameNonExistentError: if there is no such node.
        """
        return self._by_node(node_name, node_namespace, True, _topic(no_demangle))

    def get_subscriber_names_and_types_by_node(
        self, node_name: str, node_namespace: str, no_demangle: bool = False
    ) -> NamesAndTypes:
        """Return the topics a node subscribes to, with their types.

        :raises NodeNameNonExistentError: if there is no such node.
        """
        return self._by_node(node_name, node_namespace, False, _topic(no_demangle))

    def get_service_names_and_types_by_node(
        self, node_name: str, node_namespace: str
    ) -> NamesAndTypes:
        """Return the services a node offers, with their types.

        :raises NodeNameNonExistentError: if there is no such node.
        """
        return self._by_node(node_name, node_namespace, False, _request)

    def get_client_names_and_types_by_node(
        self, node_name: str, node_namespace: str
    ) -> NamesAndTypes:
        """Return the services a node has clients of, with their types.

        :raises NodeNameNonExistentError: if there is no such node.
        """
        return self._by_node(node_name, node_namespace, True, _request)

    def _full(self, name: str, is_service: bool = False) -> str:
        full = expand_topic_name(name, self.get_name(), self.get_namespace())
        validate_full_topic_name(full, is_service=is_service)
        return full

    def count_publishers(self, topic_name: str) -> int:
        """Return how many publishers a topic (not remapped) has."""
        return len(graph.publishers(self._participant, f"rt{self._full(topic_name)}"))

    def count_subscribers(self, topic_name: str) -> int:
        """Return how many subscriptions a topic (not remapped) has."""
        return len(graph.subscribers(self._participant, f"rt{self._full(topic_name)}"))

    def count_clients(self, service_name: str) -> int:
        """Return how many clients a service (not remapped) has."""
        full = self._full(service_name, is_service=True)
        return len(graph.publishers(self._participant, f"rq{full}Request"))

    def count_services(self, service_name: str) -> int:
        """Return how many times a service (not remapped) is offered."""
        full = self._full(service_name, is_service=True)
        return len(graph.subscribers(self._participant, f"rq{full}Request"))

    def _info(self, topic: str, no_mangle: bool, writers: bool) -> list[TopicEndpointInfo]:
        if not no_mangle:
            full = self._full(topic)
            node, namespace = self.get_name(), self.get_namespace()
            topic = "rt" + remapping.remap(self._rules, full, "topic", node, namespace)
        here = self._participant
        owners = {g: n for n in self._nodes_seen() for g in n[3] | n[4]}
        unknown = ("_NODE_NAME_UNKNOWN_", "_NODE_NAMESPACE_UNKNOWN_")
        infos = []
        for end in graph.publishers(here, topic) if writers else graph.subscribers(here, topic):
            owner = owners.get(end.gid, unknown)
            kind = store.ros_name(end.type)
            kinds = TopicEndpointTypeEnum
            infos.append(
                TopicEndpointInfo(
                    node_name=owner[0],
                    node_namespace=owner[1],
                    topic_type=end.type if no_mangle or kind is None else kind,
                    topic_type_hash=TypeHash.from_text(end.tags.get("typehash", "")),
                    endpoint_type=kinds.PUBLISHER if writers else kinds.SUBSCRIPTION,
                    endpoint_gid=list(end.gid),
                    qos_profile=_profile(end.policies),
                )
            )
        return infos

    def get_publishers_info_by_topic(
        self, topic_name: str, no_mangle: bool = False
    ) -> list[TopicEndpointInfo]:
        """Return information on each publisher of a topic.

        :param no_mangle: whether the name is the one that DDS uses.
        """
        return self._info(topic_name, no_mangle, writers=True)

    def get_subscriptions_info_by_topic(
        self, topic_name: str, no_mangle: bool = False
    ) -> list[TopicEndpointInfo]:
        """Return information on each subscription of a topic.

        :param no_mangle: whether the name is the one that DDS uses.
        """
        return self._info(topic_name, no_mangle, writers=False)

    def wait_for_node(self, fully_qualified_node_name: str, timeout: float) -> bool:
        """Wait until a node is in the graph.

        :param fully_qualified_node_name: its name with its namespace.
        :param timeout: how long to wait in seconds; for ever if negative.
        :return: whether it is there.
        """
        name = "/" + fully_qualified_node_name.lstrip("/")
        end = time.monotonic() + timeout
        while name not in self.get_fully_qualified_node_names():
            left = end - time.monotonic()
            if timeout >= 0 and left <= 0:
                return False
            time.sleep(0.02 if timeout < 0 else min(0.02, left))
        return True


def _names(ends: list[graph.Endpoint], read: Callable[[Any], Any]) -> NamesAndTypes:
    """Collect the types by name, of those endpoints that ``read`` gives a name and type for."""
    found: dict[str, set[str]] = {}
    for end in ends:
        entry = read(end)
        if entry is not None:
            found.setdefault(entry[0], set()).add(entry[1])
    return [(name, sorted(found[name])) for name in sorted(found)]


def _topic(no_demangle: bool) -> Callable[[graph.Endpoint], tuple[str, str] | None]:
    def read(end: graph.Endpoint) -> tuple[str, str] | None:
        if no_demangle:
            return end.topic, end.type
        kind = store.ros_name(end.type)
        if kind is None or not end.topic.startswith("rt/"):
            return None
        return end.topic[2:], kind

    return read


def _service(end: graph.Endpoint) -> tuple[str, str] | None:
    return _request(end) or _part(end, "rr/", "Reply", "_Response")


def _request(end: graph.Endpoint) -> tuple[str, str] | None:
    return _part(end, "rq/", "Request", "_Request")


def _part(end: graph.Endpoint, prefix: str, suffix: str, part: str) -> tuple[str, str] | None:
    kind = store.ros_name(end.type)
    if kind is None or not (end.topic.startswith(prefix) and end.topic.endswith(suffix)):
        return None
    return end.topic[2 : -len(suffix)], kind.removesuffix(part)


def _profile(policies: Any) -> QoSProfile:
    """Return the profile of a discovered endpoint; its history is not announced."""
    return QoSProfile(
        history=HistoryPolicy.UNKNOWN if not policies.depth else HistoryPolicy.KEEP_LAST,
        depth=policies.depth,
        reliability=ReliabilityPolicy.RELIABLE
        if policies.reliable
        else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL
        if policies.transient_local
        else DurabilityPolicy.VOLATILE,
        lifespan=Duration(nanoseconds=policies.lifespan),
        deadline=Duration(nanoseconds=policies.deadline),
        liveliness=LivelinessPolicy.MANUAL_BY_TOPIC
        if policies.manual_liveliness
        else LivelinessPolicy.AUTOMATIC,
        liveliness_lease_duration=Duration(nanoseconds=policies.lease),
    )
