"""Copies of messages for delivery within the process, generated per type.

A copy holds what a receiver would get over the wire: plain numbers and strings, its own arrays.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

from rclpy_cyclone.types.classes import message_class
from rclpy_cyclone.types.store import TYPECODES, Field, fields

_PLAIN = {"bool": bool, "byte": bytes, "string": str, "float32": float, "float64": float}


@cache
def copier(typename: str) -> Callable[[Any], Any]:
    """Return ``f(message)``, which gives a deep copy of a message of this type."""
    space: dict[str, Any] = {}
    lines = ["def f(m0):"]
    _message(typename, "m0", "c0", space, lines)
    lines.append("    return c0")
    exec("\n".join(lines), space)
    return space["f"]


def _message(typename: str, src: str, dst: str, space: dict[str, Any], lines: list[str]) -> None:
    cls = message_class(typename)
    key = f"k{len(space)}"
    space[key], space[f"n{key}"] = cls, cls.__new__
    lines.append(f"    {dst} = n{key}({key})")
    for name, field in fields(typename):
        value = f"{src}._{name}"
        if field.kind == "one" and field.nested:
            inner = f"{len(lines)}"
            lines.append(f"    m{inner} = {value}")
            _message(field.base, f"m{inner}", f"c{inner}", space, lines)
            lines.append(f"    {dst}._{name} = c{inner}")
        elif field.kind == "one":
            kind = _PLAIN.get(field.base, int)
            if field.base == "float32":  # the wire would round it
                space["f32"] = _round
                lines.append(f"    {dst}._{name} = f32({value})")
                continue
            lines.append(f"    v = {value}")
            lines.append(
                f"    {dst}._{name} = v if v.__class__ is {kind.__name__} else {kind.__name__}(v)"
            )
        else:
            lines.append(f"    {dst}._{name} = {_many(field, value, space)}")


def _many(field: Field, value: str, space: dict[str, Any]) -> str:
    if field.nested:
        key = f"k{len(space)}"
        space[key] = copier(field.base)
        return f"[{key}(v) for v in {value}]"
    if field.base in TYPECODES:
        return f"{value}[:]" if field.kind == "sequence" else f"{value}.copy()"
    return f"list({value})"


def _round(value: float) -> float:
    import struct

    return struct.unpack("f", struct.pack("f", value))[0]
