"""ROS 2 message definitions, type hashes and serialisation, from the rosbags type store."""

from __future__ import annotations

from functools import cache
from typing import Any


@cache
def typestore() -> Any:
    """The Jazzy type store of rosbags (takes a tenth of a second, hence on demand)."""
    from rosbags.typesys import Stores, get_typestore

    return get_typestore(Stores.ROS2_JAZZY)


def definition(message_type: str) -> str:
    """The `ros2msg` text of a type with all it depends on."""
    text, _ = typestore().generate_msgdef(message_type, ros_version=2)
    return str(text)


def type_hash(message_type: str) -> str:
    """The type's REP 2011 hash, `RIHS01_<64 hex digits>`."""
    return str(typestore().hash_rihs01(message_type))
