"""Messages to CDR and back, by the functions that `codec` generates for each type."""

from __future__ import annotations

import struct
from collections.abc import Callable
from functools import cache
from typing import Any

from rclpy_cyclone.types import codec


def serialise(message: Any) -> bytearray:
    """Return the CDR representation of a message, header included."""
    return _top(message._ros_name)[0](message)


def deserialise(data: bytes, cls: Any) -> Any:
    """Return the message a CDR representation stands for.

    :param data: the representation, header included; either byte order.
    :raises ValueError: if the data does not hold such a message.
    """
    return decoder(cls)(bytes(data))


@cache
def decoder(cls: Any) -> Callable[[bytes], Any]:
    """Return ``f(data)``, which does for one class what :func:`deserialise` does."""
    little = _top(cls._ros_name)[1]

    def decode(data: bytes) -> Any:
        try:
            if data[1] == 1:
                return little(data[4:])
            if data[1] == 0:
                return codec.top_deserialiser(cls._ros_name, ">")(data[4:])
        except (struct.error, IndexError, UnicodeDecodeError) as error:
            raise ValueError(f"not a serialised {cls._ros_name}: {error}") from error
        raise ValueError(f"not plain CDR: header {data[:4].hex()}")

    return decode


@cache
def _top(typename: str) -> tuple[Callable[[Any], bytearray], Callable[[bytes], Any]]:
    return codec.top_serialiser(typename), codec.top_deserialiser(typename)


def codec_of(cls: Any) -> tuple[Callable[[Any], bytearray], Callable[[bytes], Any]]:
    """Return ``(serialise, deserialise)`` of a class; the latter takes what follows the header."""
    return _top(cls._ros_name)
