"""The C functions of Cyclone DDS that are called directly, with plain integers as handles.

``blocking`` gives up the interpreter lock during a call; ``quick`` keeps it, which costs less and
is for calls that neither wait nor take long.
"""

from __future__ import annotations

import ctypes as ct
from typing import Any

from cyclonedds import _clayer
from cyclonedds.internal import DDS, dds_c_t, dds_infinity

INFINITY: int = dds_infinity
ANY_STATE = 0x7F  # all sample, view and instance states
WRITE = _clayer.ddspy_write
TAKE = _clayer.ddspy_take

ERRORS = {
    -1: "error", -2: "unsupported", -3: "bad parameter", -4: "precondition not met",
    -5: "out of resources", -6: "not enabled", -7: "immutable policy",
    -8: "inconsistent policy", -9: "already deleted", -10: "timeout", -11: "no data",
    -12: "illegal operation", -13: "not allowed by security",
}  # fmt: skip

_path = DDS._dll_handle._name
blocking: Any = ct.CDLL(_path)
quick: Any = ct.PyDLL(_path)

_entity, _ptr, _int32, _size = ct.c_int32, ct.c_void_p, ct.c_int32, ct.c_size_t
_PROTOTYPES: dict[str, tuple[list[Any], Any]] = {
    "dds_create_domain": ([ct.c_uint32, ct.c_char_p], _entity),
    "dds_create_participant": ([ct.c_uint32, _ptr, _ptr], _entity),
    "dds_create_writer": ([_entity, _entity, _ptr, _ptr], _entity),
    "dds_create_reader": ([_entity, _entity, _ptr, _ptr], _entity),
    "dds_create_readcondition": ([_entity, ct.c_uint32], _entity),
    "dds_create_guardcondition": ([_entity], _entity),
    "dds_set_guardcondition": ([_entity, ct.c_bool], _int32),
    "dds_take_guardcondition": ([_entity, ct.POINTER(ct.c_bool)], _int32),
    "dds_create_waitset": ([_entity], _entity),
    "dds_waitset_attach": ([_entity, _entity, ct.c_ssize_t], _int32),
    "dds_waitset_detach": ([_entity, _entity], _int32),
    "dds_waitset_wait": ([_entity, _ptr, _size, ct.c_int64], _int32),
    "dds_delete": ([_entity], _int32),
    "dds_get_guid": ([_entity, _ptr], _int32),
    "dds_get_instance_handle": ([_entity, ct.POINTER(ct.c_uint64)], _int32),
    "dds_get_matched_subscriptions": ([_entity, _ptr, _size], _int32),
    "dds_get_matched_publications": ([_entity, _ptr, _size], _int32),
    "dds_set_status_mask": ([_entity, ct.c_uint32], _int32),
    "dds_get_status_changes": ([_entity, ct.POINTER(ct.c_uint32)], _int32),
    "dds_wait_for_acks": ([_entity, ct.c_int64], _int32),
    "dds_assert_liveliness": ([_entity], _int32),
    "dds_get_publication_matched_status": ([_entity, _ptr], _int32),
    "dds_get_subscription_matched_status": ([_entity, _ptr], _int32),
    "dds_get_offered_incompatible_qos_status": ([_entity, _ptr], _int32),
    "dds_get_requested_incompatible_qos_status": ([_entity, _ptr], _int32),
    "dds_get_offered_deadline_missed_status": ([_entity, _ptr], _int32),
    "dds_get_requested_deadline_missed_status": ([_entity, _ptr], _int32),
    "dds_get_liveliness_lost_status": ([_entity, _ptr], _int32),
    "dds_get_liveliness_changed_status": ([_entity, _ptr], _int32),
    "dds_get_sample_lost_status": ([_entity, _ptr], _int32),
}
for _name, (_args, _result) in _PROTOTYPES.items():
    for _library in (blocking, quick):
        _function = getattr(_library, _name)
        _function.argtypes, _function.restype = _args, _result

Status = dds_c_t  # the status structures

# Status bits (dds_status_id) used in status masks.
OFFERED_DEADLINE_MISSED = 1 << 1
REQUESTED_DEADLINE_MISSED = 1 << 2
OFFERED_INCOMPATIBLE_QOS = 1 << 3
REQUESTED_INCOMPATIBLE_QOS = 1 << 4
SAMPLE_LOST = 1 << 5
LIVELINESS_LOST = 1 << 9
LIVELINESS_CHANGED = 1 << 10
PUBLICATION_MATCHED = 1 << 11
SUBSCRIPTION_MATCHED = 1 << 12


class DdsError(RuntimeError):
    """A call into Cyclone DDS failed."""


def check(result: int, what: str) -> int:
    """Return the result of a call, which must not be negative.

    :raises DdsError: naming what was attempted and Cyclone's reason.
    """
    if result < 0:
        raise DdsError(f"{what}: {ERRORS.get(result, result)}")
    return result


def guid(entity: int) -> bytes:
    """Return the 16 bytes that name an entity on the network."""
    raw = (ct.c_uint8 * 16)()
    check(quick.dds_get_guid(entity, ct.byref(raw)), "get guid")
    return bytes(raw)


def delete(entity: int) -> None:
    """Delete an entity and its children. One that is gone already is no error."""
    blocking.dds_delete(entity)
