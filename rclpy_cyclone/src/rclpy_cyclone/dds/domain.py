"""Cyclone's configuration of a domain, from the environment variables of ROS 2.

Loopback only unless ``ROS_AUTOMATIC_DISCOVERY_RANGE=SUBNET`` asks for more.
"""

from __future__ import annotations

import os
import threading
from xml.sax.saxutils import quoteattr

from rclpy_cyclone.dds.clib import blocking, check, delete

_RANGES = ("OFF", "LOCALHOST", "SUBNET", "SYSTEM_DEFAULT")
_lock = threading.Lock()
_open: dict[int, list[int]] = {}  # domain id -> [handle, number of users]


def discovery_range() -> str:
    """Return the discovery range asked for: ``OFF``, ``LOCALHOST``, ``SUBNET`` or
    ``SYSTEM_DEFAULT``.

    :raises ValueError: for a value that ROS 2 does not know.
    """
    if os.environ.get("ROS_LOCALHOST_ONLY") == "1":
        return "LOCALHOST"
    wanted = os.environ.get("ROS_AUTOMATIC_DISCOVERY_RANGE", "")
    if not wanted:
        return "LOCALHOST"
    if wanted not in _RANGES:
        raise ValueError(
            f"ROS_AUTOMATIC_DISCOVERY_RANGE={wanted!r} is none of {', '.join(_RANGES)}"
        )
    return wanted


def configuration(range_: str) -> str:
    """Return Cyclone's configuration for a discovery range (``CYCLONEDDS_URI`` comes on top)."""
    own = ""
    if range_ in ("OFF", "LOCALHOST"):
        # Data by multicast would wake every process of the machine, whether it listens or not.
        own += (
            "<General><Interfaces><NetworkInterface address='127.0.0.1'/></Interfaces>"
            "<AllowMulticast>spdp</AllowMulticast></General>"
        )
    if range_ == "OFF":
        own += (
            "<Discovery><ParticipantIndex>none</ParticipantIndex>"
            f"<Tag>ros_discovery_off_{os.getpid()}</Tag></Discovery>"
        )
    elif range_ in ("LOCALHOST", "SUBNET"):
        named = os.environ.get("ROS_STATIC_PEERS", "").split(";")
        peers = ["localhost", *(p.strip() for p in named if p.strip())]
        own += (
            "<Discovery><ParticipantIndex>auto</ParticipantIndex>"
            "<MaxAutoParticipantIndex>32</MaxAutoParticipantIndex><Peers>"
            + "".join(f"<Peer address={quoteattr(p)}/>" for p in peers)
            + "</Peers></Discovery>"
        )
    # A thread for each socket sleeps in the receive call itself, not in a poll before it.
    own += "<Internal><MultipleReceiveThreads>true</MultipleReceiveThreads></Internal>"
    from_user = os.environ.get("CYCLONEDDS_URI", "")
    return f"<CycloneDDS><Domain Id='any'>{own}</Domain></CycloneDDS>,{from_user}".rstrip(",")


def domain_id() -> int:
    """Return the domain of ``ROS_DOMAIN_ID``, 0 if it is not set.

    :raises ValueError: if it is set to something else than a number of a domain.
    """
    text = os.environ.get("ROS_DOMAIN_ID", "").strip()
    if not text:
        return 0
    if not text.isdecimal() or int(text) > 232:
        raise ValueError(f"ROS_DOMAIN_ID={text!r} is not an integer from 0 to 232")
    return int(text)


def acquire(number: int) -> None:
    """Configure a domain, if this process has not done so, and count one more user."""
    with _lock:
        if number not in _open:
            xml = configuration(discovery_range()).encode()
            handle = blocking.dds_create_domain(number, xml)
            if handle == -4:  # opened by someone else in this process, with his configuration
                handle = 0
            _open[number] = [check(handle, f"configure DDS domain {number}"), 0]
        _open[number][1] += 1


def release(number: int) -> None:
    """Count one user less, and close the domain behind the last one."""
    with _lock:
        entry = _open[number]
        entry[1] -= 1
        if entry[1] == 0:
            del _open[number]
            if entry[0]:
                delete(entry[0])
