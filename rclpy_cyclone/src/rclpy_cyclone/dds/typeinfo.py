"""DDS types for topics: the XTypes description that Cyclone announces for each topic.

Genuine ROS 2 peers over Cyclone announce none and match by name; peers that do are compared
member by member, so the description is the true one.
"""

from __future__ import annotations

from functools import cache
from types import SimpleNamespace
from typing import Any

from cyclonedds.idl import make_idl_struct
from cyclonedds.idl import types as _idl
from cyclonedds.idl._support import Endianness
from cyclonedds.idl._xt_builder import XTBuilder

from rclpy_cyclone.types import store
from rclpy_cyclone.types.store import EMPTY, Field, dds_name, fields

idl: Any = _idl  # whose generics type checkers do not see through
_BASES: dict[str, Any] = {
    "bool": bool, "byte": idl.uint8, "char": idl.uint8, "int8": idl.int8, "uint8": idl.uint8,
    "int16": idl.int16, "uint16": idl.uint16, "int32": idl.int32, "uint32": idl.uint32,
    "int64": idl.int64, "uint64": idl.uint64, "float32": idl.float32, "float64": idl.float64,
}  # fmt: skip
_XCDR1 = 1  # bit of the encodings a topic offers


@cache
def _struct(typename: str, header: bool = False) -> Any:
    members: dict[str, Any] = {}
    if header:  # what rmw_cyclonedds puts before a request or response
        members = {"client_id": idl.uint64, "sequence_number": idl.int64}
    members.update({name: _member(field) for name, field in fields(typename)})
    if not members:
        members = {EMPTY: idl.uint8}
    base = typename.rsplit("/", 1)[1]
    return make_idl_struct(f"{base}_", dds_name(typename).replace("::", "."), members)


def _member(field: Field) -> Any:
    if field.nested:
        item = _struct(field.base)
    elif field.base == "string":
        item = idl.bounded_str[field.text_bound] if field.text_bound else str
    else:
        item = _BASES[field.base]
    if field.kind == "array":
        return idl.array[item, field.length]
    if field.kind == "sequence":
        return idl.sequence[item, field.length] if field.length else idl.sequence[item]
    return item


@cache
def topic_type(typename: str) -> Any:
    """Return what the C layer needs to know of a topic's type, as a class with ``__idl__``."""
    kind = typename.split("/")[1]
    struct = _struct(typename, kind == "srv")
    information, mapping = XTBuilder.process_type(struct)
    raw = tuple(
        part.serialize(endianness=Endianness.Little, use_version_2=True)[4:]
        for part in (information, mapping)
    )
    description = SimpleNamespace(
        idl_transformed_typename=dds_name(typename),
        data_type_props=0,
        supported_versions=_XCDR1,
        _xt_bytedata=raw,
    )
    return type(typename.replace("/", "_"), (), {"__idl__": description})


def user_data(typename: str) -> bytes:
    """Return the USER_DATA entry that tells an endpoint's type hash."""
    return f"typehash={store.type_hash(typename)};".encode()
