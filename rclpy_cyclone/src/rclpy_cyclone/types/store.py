"""Definitions of every served type: messages from rosbags, services from :mod:`.services`.

A type is named as in ``sensor_msgs/msg/JointState``; its fields are ``(name, Field)``.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from rclpy_cyclone.types import services

EMPTY = "structure_needs_at_least_one_member"
# Sizes in CDR, which are the alignments too.
SIZES = {
    "bool": 1, "byte": 1, "char": 1, "int8": 1, "uint8": 1, "int16": 2, "uint16": 2,
    "int32": 4, "uint32": 4, "float32": 4, "int64": 8, "uint64": 8, "float64": 8,
}  # fmt: skip
# Types whose sequences are array.array, and whose fixed arrays are numpy arrays.
TYPECODES = {
    "int8": "b", "uint8": "B", "char": "B", "int16": "h", "uint16": "H", "int32": "i",
    "uint32": "I", "int64": "q", "uint64": "Q", "float32": "f", "float64": "d",
}  # fmt: skip


@dataclass(frozen=True)
class Field:
    """Type of one field.

    :param kind: ``'one'``, ``'array'`` (fixed length) or ``'sequence'``.
    :param base: primitive name, ``'string'``, or the full name of a nested message.
    :param nested: whether ``base`` names a message.
    :param length: length of an array, or bound of a sequence (0: unbounded).
    :param text_bound: bound of a string (0: unbounded).
    """

    kind: str
    base: str
    nested: bool
    length: int = 0
    text_bound: int = 0


@cache
def typestore() -> Any:
    """Return the rosbags type store of Jazzy, with the service types registered."""
    store: Any = get_typestore(Stores.ROS2_JAZZY)
    for name, (request, response) in services.DEFINITIONS.items():
        package, service = name.split("/srv/")
        for text, part in ((request, "Request"), (response, "Response")):
            parsed = get_types_from_msg(text, f"{package}/msg/{service}_{part}")
            consts, members = next(iter(parsed.values()))
            filler = [(EMPTY, (Nodetype.BASE, ("uint8", 0)))]
            store.fielddefs[f"{package}/srv/{service}_{part}"] = (consts, members or filler)
        _register_service(store, name)
    return store


def _register_service(store: Any, name: str) -> None:
    """Add the event type and the service type itself, which the hash of the service covers."""
    event = f"{name}_Event"
    request, response = f"{name}_Request", f"{name}_Response"
    many = Nodetype.SEQUENCE
    one = Nodetype.NAME
    store.fielddefs[event] = (
        [],
        [
            ("info", (one, "service_msgs/msg/ServiceEventInfo")),
            ("request", (many, ((one, request), 1))),
            ("response", (many, ((one, response), 1))),
        ],
    )
    store.fielddefs[name] = (
        [],
        [
            ("request_message", (one, request)),
            ("response_message", (one, response)),
            ("event_message", (one, event)),
        ],
    )


@cache
def fields(name: str) -> tuple[tuple[str, Field], ...]:
    """Return the fields of a type, in order. The filler of an empty type is not among them."""
    return tuple(
        (field, _field(desc)) for field, desc in typestore().fielddefs[name][1] if field != EMPTY
    )


def _field(desc: Any) -> Field:
    kind, length = "one", 0
    if desc[0] == Nodetype.ARRAY:
        kind, (desc, length) = "array", desc[1]
    elif desc[0] == Nodetype.SEQUENCE:
        kind, (desc, length) = "sequence", desc[1]
    if desc[0] == Nodetype.NAME:
        return Field(kind, desc[1], True, length)
    base, bound = desc[1]
    return Field(kind, base, False, length, bound if base == "string" else 0)


def constants(name: str) -> list[tuple[str, str, Any]]:
    """Return ``(name, type, value)`` of every constant of a type."""
    return list(typestore().fielddefs[name][0])


@cache
def names() -> frozenset[str]:
    """Return the full names of all served messages (service parts included)."""
    return frozenset(typestore().fielddefs)


@cache
def type_hash(name: str) -> str:
    """Return the RIHS01 hash of a type, as ``RIHS01_<64 hex digits>``."""
    return typestore().hash_rihs01(name)


def dds_name(name: str) -> str:
    """Return the DDS type name, e.g. ``sensor_msgs::msg::dds_::JointState_``."""
    package, kind, base = name.split("/")
    return f"{package}::{kind}::dds_::{base}_"


def ros_name(dds: str) -> str | None:
    """Return ``sensor_msgs/msg/JointState`` for a DDS type name, ``None`` if it is no ROS type."""
    parts = dds.split("::")
    if len(parts) < 3 or parts[-2] != "dds_" or not parts[-1].endswith("_"):
        return None
    return "/".join([*parts[:-2], parts[-1][:-1]])
