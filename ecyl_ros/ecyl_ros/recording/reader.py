"""Recordings in: messages joined by their stamps into arrays."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..arrays import FloatArray, StampArray
from ..errors import InputError
from .bag import read_bag
from .bag_contents import Bag
from .cdr import CdrError, decode
from .signals import Recording
from .topics import JOINT_STATES, TOPICS, TopicSpec


class StampError(InputError):
    """Stamps that do not fit together as one sample's should; `mapped` can set that right."""


@dataclass(frozen=True)
class _Samples:
    """One topic's stamps and its signals by name."""

    spec: TopicSpec
    stamp_ns: StampArray
    signals: Mapping[str, FloatArray]


def read_recording(
    path: str | Path,
    *,
    topics: Sequence[TopicSpec] = TOPICS,
    joint_names: Mapping[str, str] | None = None,
) -> Recording:
    """Read a recording of this project's topics from an MCAP or sqlite3 file, or a folder of them.

    The grid is that of the joint_states topic, or where that is missing, of all topics together.
    Other topics are joined to it by equal header stamps. `Recording.notes` says what was cut off,
    what is missing, and what found no place on the grid.

    Args:
        path: file or folder.
        topics: where the signals stand (see `renamed` for other topic names).
        joint_names: what the file calls the joints `rotor`, `rod` and `load`, where it differs.

    Raises:
        InputError: nothing to read (see `read_bag`), none of the topics, a topic of another type,
            messages that do not parse, none of the joints, stamps that repeat or go back, or
            topics without a stamp in common.
    """
    names = dict(joint_names or {})
    bag = read_bag(path, topics={topic.name for topic in topics})
    notes = list(bag.notes)
    found = [
        samples for topic in topics if (samples := _samples(bag, topic, names, notes)) is not None
    ]
    if not found:
        held = ", ".join(sorted(bag.topics)) or "none"
        wanted = ", ".join(topic.name for topic in topics)
        cut = "; the file was cut off" if bag.notes else ""
        raise InputError(f"{path}: no messages on any of {wanted}; its topics: {held}{cut}")
    by_key = {samples.spec.key: samples for samples in found}
    if JOINT_STATES.key in by_key:
        grid = by_key[JOINT_STATES.key].stamp_ns
    else:
        grid = np.unique(np.concatenate([samples.stamp_ns for samples in found]))
    signals: dict[str, Any] = {}
    for samples in found:
        signals.update(_on_grid(bag, samples, grid, notes))
    return Recording(stamp_ns=grid, **signals, notes=tuple(notes))


def _samples(
    bag: Bag, spec: TopicSpec, names: Mapping[str, str], notes: list[str]
) -> _Samples | None:
    topic = bag.topics.get(spec.name)
    if topic is None or not topic.data:
        why = "no such topic" if topic is None else "no message on it"
        notes.append(f"{bag.path}: {spec.name}: {why}")
        return None
    where = f"{bag.path}: {spec.name}"
    if topic.type != spec.type:
        raise InputError(f"{where}: type is {topic.type}, expected {spec.type}")
    if topic.encoding != "cdr":
        raise InputError(f"{where}: message encoding is {topic.encoding!r}, expected 'cdr'")
    paths = {_renamed(path, names): signal for path, signal in spec.signals.items()}
    try:
        stamps, values, joints = decode(spec.type, topic.data, list(paths))
    except CdrError as error:
        raise InputError(f"{where}: {error} (expected {spec.type})") from None
    wrong = np.flatnonzero(stamps[1:] <= stamps[:-1])
    if wrong.size:
        row = int(wrong[0]) + 1
        how = "repeats" if stamps[row] == stamps[row - 1] else "goes back to"
        raise StampError(
            f"{where}: header.stamp of message {row} {how} {stamps[row]} ns, expected stamps "
            "that increase"
        )
    expected = [names.get(joint, joint) for joint in spec.joints]
    missing = [joint for joint in expected if joint not in joints]
    if expected and len(missing) == len(expected):
        raise InputError(
            f"{where}: joint names are [{', '.join(sorted(joints))}], expected "
            f"{' or '.join(expected)}"
        )
    notes.extend(f"{where}: no joint called {joint}" for joint in missing)
    return _Samples(spec, stamps, {signal: values[path] for path, signal in paths.items()})


def _renamed(path: str, names: Mapping[str, str]) -> str:
    joint, _, field = path.rpartition(".")
    return f"{names.get(joint, joint)}.{field}"


def _on_grid(
    bag: Bag, samples: _Samples, grid: StampArray, notes: list[str]
) -> dict[str, FloatArray]:
    """The signals at the grid's stamps, NaN where the topic has no message of that stamp."""
    stamps = samples.stamp_ns
    if np.array_equal(stamps, grid):
        return dict(samples.signals)
    where = f"{bag.path}: {samples.spec.name}"
    places = np.minimum(np.searchsorted(grid, stamps), grid.size - 1)
    common = grid[places] == stamps
    if not common.any():
        raise StampError(
            f"{where}: none of its {stamps.size} stamps occurs in joint_states; expected all "
            "topics of one sample to carry the same stamp"
        )
    lacking = grid.size - int(common.sum())
    if lacking:
        notes.append(f"{where}: {lacking} of {grid.size} samples missing")
    if not common.all():
        notes.append(f"{where}: {int((~common).sum())} samples left out, at stamps of no other")
    joined = {}
    for name, values in samples.signals.items():
        joined[name] = np.full(grid.size, np.nan)
        joined[name][places[common]] = values[common]
    return joined
