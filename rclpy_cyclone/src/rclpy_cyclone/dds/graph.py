"""What is known of the other endpoints and participants in the domain."""

from __future__ import annotations

import ctypes as ct
from dataclasses import dataclass, field
from typing import Any

from cyclonedds import _clayer
from cyclonedds.builtin_types import cqos_to_qos
from cyclonedds.qos import Policy

from rclpy_cyclone.dds import qos
from rclpy_cyclone.dds.clib import blocking, check

_MOST = 8192
_ALIVE = 0x1F  # any sample and view state, instances alive


@dataclass
class Endpoint:
    """A reader or writer somewhere in the domain.

    :param gid: the 16 bytes that name it.
    :param participant: the 16 bytes that name its participant.
    :param topic: DDS name of the topic.
    :param type: DDS name of the type.
    :param policies: its policies.
    :param tags: the ``key=value;`` pairs of its USER_DATA.
    """

    gid: bytes
    participant: bytes
    topic: str
    type: str
    policies: qos.Policies
    tags: dict[str, str] = field(default_factory=dict)


def tags(quality: Any) -> dict[str, str]:
    """Return the ``key=value;`` pairs in a QoS's USER_DATA."""
    if quality is None or Policy.Userdata not in quality:
        return {}
    text = bytes(quality[Policy.Userdata].data).decode("utf-8", "replace")
    return dict(p.split("=", 1) for p in text.split(";") if "=" in p)


def _endpoint(
    key: bytes,
    owner: bytes,
    _handle: int,
    topic: str,
    kind: str,
    quality: Any,
    _info: Any,
    _id: Any,
) -> Endpoint:
    return Endpoint(bytes(key), bytes(owner), topic, kind, qos.policies_of(quality), tags(quality))


def _handles(call: Any, entity: int) -> list[int]:
    count = check(call(entity, None, 0), "get matches")
    if not count:
        return []
    array = (ct.c_uint64 * count)()
    count = min(count, check(call(entity, ct.cast(array, ct.c_void_p), count), "get matches"))
    return list(array[:count])


def matched_readers(writer: int) -> list[Endpoint]:
    """Return the readers a writer is matched with."""
    get = _clayer.ddspy_get_matched_subscription_data
    found = (
        get(writer, handle, _endpoint, cqos_to_qos)
        for handle in _handles(blocking.dds_get_matched_subscriptions, writer)
    )
    return [e for e in found if e is not None]


def matched_writers(reader: int) -> list[Endpoint]:
    """Return the writers a reader is matched with."""
    found = (
        matched_writer(reader, handle)
        for handle in _handles(blocking.dds_get_matched_publications, reader)
    )
    return [e for e in found if e is not None]


def matched_writer(reader: int, handle: int) -> Endpoint | None:
    """Return a writer that a reader is matched with, ``None`` if it is (no longer)."""
    return _clayer.ddspy_get_matched_publication_data(reader, handle, _endpoint, cqos_to_qos)


def publishers(participant: Any, topic: str | None = None) -> list[Endpoint]:
    """Return all writers in the domain, or those of one topic."""
    return _read(participant, "publications", topic)


def subscribers(participant: Any, topic: str | None = None) -> list[Endpoint]:
    """Return all readers in the domain, or those of one topic."""
    return _read(participant, "subscriptions", topic)


def _read(participant: Any, which: str, topic: str | None) -> list[Endpoint]:
    """Bring the list of endpoints up to date and return it.

    Only what has changed since the last call is taken from DDS: turning one endpoint's QoS into
    Python takes some 100 us, and callers ask often.
    """
    with participant.lock:
        known: dict[bytes, Endpoint] = participant.__dict__.setdefault(f"known_{which}", {})
        reader = _builtin(participant, which, every_state=True)

        def change(*args: Any) -> tuple[bytes, Endpoint | None]:
            gone = args[5] is None or (args[6] is not None and not args[6].valid_data)
            return bytes(args[0]), None if gone else _endpoint(*args)

        samples = _clayer.ddspy_take_endpoint(reader, _MOST, change, cqos_to_qos)
        if isinstance(samples, int):
            check(samples, f"read {which}")
            samples = []
        for gid, endpoint in samples:
            if endpoint is None:
                known.pop(gid, None)
            else:
                known[gid] = endpoint
        return [e for e in known.values() if topic is None or e.topic == topic]


def participants(participant: Any) -> dict[bytes, dict[str, str]]:
    """Return the participants in the domain by gid, with their tags (``enclave``)."""
    reader = _builtin(participant, "participants")

    def make(key: bytes, quality: Any, info: Any) -> Any:
        if quality is None or not info.valid_data:
            return None
        return bytes(key), tags(quality)

    samples = _clayer.ddspy_read_participant(reader, _MOST, make, cqos_to_qos)
    if isinstance(samples, int):
        check(samples, "read participants")
        return {}
    return dict(s for s in samples if s is not None)


def _builtin(participant: Any, which: str, *, every_state: bool = False) -> int:
    """Return the participant's reader of a built-in topic, made on first use.

    With ``every_state`` it also gives those who have gone, otherwise only who is there.
    """
    with participant.lock:
        readers = participant.__dict__.setdefault("builtin_readers", {})
        if which not in readers:
            from cyclonedds import builtin

            pseudo = {
                "publications": builtin.BuiltinTopicDcpsPublication,
                "subscriptions": builtin.BuiltinTopicDcpsSubscription,
                "participants": builtin.BuiltinTopicDcpsParticipant,
            }[which]._ref
            made = blocking.dds_create_reader(participant.entity, pseudo, None, None)
            check(made, f"create reader of {which}")
            if not every_state:
                made = blocking.dds_create_readcondition(made, _ALIVE)
                check(made, f"create read condition of {which}")
            readers[which] = made
        return readers[which]
