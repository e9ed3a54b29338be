"""Types as ``type_description_interfaces.msg.TypeDescription``."""

from __future__ import annotations

from typing import Any

from rclpy_cyclone.types.classes import message_class
from rclpy_cyclone.types.store import EMPTY, Field, fields

# Numbers of the primitive types in FieldType.msg; sequences and arrays add to them.
_IDS = {
    "int8": 2, "uint8": 3, "int16": 4, "uint16": 5, "int32": 6, "uint32": 7, "int64": 8,
    "uint64": 9, "float32": 10, "float64": 11, "char": 13, "bool": 15, "byte": 16, "string": 17,
}  # fmt: skip
_NESTED, _BOUNDED_STRING = 1, 21
_ARRAY, _BOUNDED, _UNBOUNDED = 48, 96, 144


def _msg(name: str) -> Any:
    return message_class(f"type_description_interfaces/msg/{name}")


def describe(typename: str) -> Any:
    """Return the description of a type, with those of the types it refers to."""
    used: dict[str, Any] = {}
    main = _individual(typename, used)
    others = [used[name] for name in sorted(used) if name != typename]
    return _msg("TypeDescription")(type_description=main, referenced_type_descriptions=others)


def _individual(typename: str, used: dict[str, Any]) -> Any:
    members = fields(typename) or ((EMPTY, Field("one", "uint8", False)),)
    result = _msg("IndividualTypeDescription")(type_name=typename)
    for name, field in members:
        if field.nested and field.base not in used:
            used[field.base] = None
            used[field.base] = _individual(field.base, used)
        result.fields.append(_msg("Field")(name=name, type=_type(field)))
    return result


def _type(field: Field) -> Any:
    number = _NESTED if field.nested else _IDS[field.base]
    if field.text_bound:
        number = _BOUNDED_STRING
    if field.kind == "array":
        number += _ARRAY
    elif field.kind == "sequence":
        number += _BOUNDED if field.length else _UNBOUNDED
    return _msg("FieldType")(
        type_id=number,
        capacity=field.length,
        string_capacity=field.text_bound,
        nested_type_name=field.base if field.nested else "",
    )
