"""Messages as middlewares send them: with bytes behind the last value."""

from __future__ import annotations

import struct

import pytest

from ecyl_ros.recording.cdr import MOST_PADDING, CdrError, decode
from ecyl_ros.recording.topics import JOINT_STATE


def _joint_state(position: float, chance: bytes = b"\0") -> bytes:
    """CDR 1 of a JointState of one joint `rod`, no velocity, no effort; by the standard's rules.

    chance: what the gaps hold that align what follows.
    """
    body = struct.pack("<iI", 3, 7)  # stamp
    body += struct.pack("<I", 1) + b"\0" + chance * 3  # frame_id, aligned
    body += struct.pack("<II", 1, 4) + b"rod\0"
    body += struct.pack("<I", 1) + chance * (-(len(body) + 4) % 8) + struct.pack("<d", position)
    body += struct.pack("<II", 0, 0)
    return b"\x00\x01\x00\x00" + body


@pytest.mark.parametrize("padding", [0, 3, 8, MOST_PADDING])
def test_padding_behind_a_message_is_no_part_of_it(padding: int) -> None:
    """Room that Fast DDS reckons for aligning arrays that are empty: the values are read."""
    messages = [_joint_state(at) + b"\0" * padding for at in (0.25, -1.5)]
    stamps, values, joints = decode(JOINT_STATE, messages, ["rod.position"])
    assert stamps.tolist() == [3_000_000_007] * 2
    assert values["rod.position"].tolist() == [0.25, -1.5]
    assert joints == {"rod"}


def test_more_than_padding_is_another_type() -> None:
    """Bytes that no alignment accounts for are refused."""
    with pytest.raises(CdrError, match="ends at byte"):
        decode(JOINT_STATE, [_joint_state(0.0) + b"\0" * (MOST_PADDING + 1)], ["rod.position"])


def test_gaps_that_hold_what_was_there_before_make_no_layout_of_their_own() -> None:
    """200 messages, each with other bytes in its gaps, as some middlewares send them: all read."""
    messages = [_joint_state(float(i), bytes([i])) for i in range(200)]
    _, values, _ = decode(JOINT_STATE, messages, ["rod.position"])
    assert values["rod.position"].tolist() == [float(i) for i in range(200)]
