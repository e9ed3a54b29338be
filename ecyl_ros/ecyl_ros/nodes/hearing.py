"""A drive's telemetry as matched samples, and into a recording when one is wanted."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

from geometry_msgs.msg import Vector3Stamped
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import JointState

from ..investigate.bounds import Sample
from ..recording.cdr import CdrError
from ..recording.sequencer import SampleSequencer
from ..recording.topics import JOINT_STATE, TOPICS
from ..recording.writer import RecordingWriter
from . import wire
from .ready_bytes import Incoming

NEEDED = ("reference", "joint_states")
_CLASSES = {JOINT_STATE: JointState}
_TOPICS = {topic.key: topic for topic in TOPICS}


def telemetry_name(key: str, names: Mapping[str, str]) -> str:
    """The topic that `key` comes on, relative to the namespace unless it is renamed."""
    return names.get(key, _TOPICS[key].name.lstrip("/"))


class Hearing:
    """Subscribes to the telemetry topics of a node's namespace.

    `begin` settles which topics belong to a sample; from then on `on_sample` is called with each,
    in the order of their stamps. A recording holds the messages as they came, under the contract's
    names.

    Attributes:
        heard, heard_first: wall time (monotonic) of the last and first message, by key.
        keys: of a sample, once settled.
        writer: of the recording, while there is one.
    """

    def __init__(
        self,
        node: Node,
        names: Mapping[str, str],
        on_sample: Callable[[Sample], None],
        on_flaw: Callable[[str], None],
    ) -> None:
        """names: topic names by key, where they are others. on_flaw: takes what a message lacks."""
        self.heard: dict[str, float] = {}
        self.heard_first: dict[str, float] = {}
        self.keys: tuple[str, ...] = ()
        self.writer: RecordingWriter | None = None
        self._node, self._on_sample, self._on_flaw = node, on_sample, on_flaw
        self._names = names
        self._sequencer: SampleSequencer | None = None
        self._stamp_ns = -1
        self._reading = {
            "reference": Incoming(JointState, "rod.position", "rod.velocity"),
            "joint_states": Incoming(JointState, "rod.position"),
            "current": Incoming(Vector3Stamped, "vector.y"),
        }
        self._values: dict[str, list[float]] = {}
        # Nothing is lost of a reliable topic; `waits_for` settles for what comes of others.
        self._subscriptions = {key: self._subscribe(key, wire.lossless()) for key in _TOPICS}
        self._settled: set[str] = set()

    def _subscribe(self, key: str, quality: QoSProfile) -> Any:
        kind: Any = _CLASSES.get(_TOPICS[key].type, Vector3Stamped)
        name = telemetry_name(key, self._names)
        hear = partial(self._on_message, key)
        return self._node.create_subscription(kind, name, hear, quality, raw=True)

    def waits_for(self) -> str | None:
        """A topic that somebody publishes and that has not been heard yet; None if all were.

        Of a publisher that sends best effort, a reliable subscription hears nothing.
        """
        waiting = None
        for key in _TOPICS:
            if key in self.heard:
                continue
            name = self._node.resolve_topic_name(telemetry_name(key, self._names))
            there = self._node.get_publishers_info_by_topic(name)
            loose = [
                one for one in there if one.qos_profile.reliability == ReliabilityPolicy.BEST_EFFORT
            ]
            if loose and key not in self._settled:
                self._settled.add(key)
                self._node.destroy_subscription(self._subscriptions[key])
                quality = QoSProfile(depth=1000, reliability=ReliabilityPolicy.BEST_EFFORT)
                self._subscriptions[key] = self._subscribe(key, quality)
            if there or key in NEEDED:
                waiting = key
        return waiting

    @property
    def begun(self) -> bool:
        """Whether samples are being made."""
        return self._sequencer is not None

    def begin(self) -> None:
        """Make samples of the topics heard until now; those of `NEEDED` have to be among them."""
        self.keys = tuple(key for key in _TOPICS if key in self.heard)
        self._sequencer = SampleSequencer(self._on_part, topics=self.keys)

    def record(self, out: Path) -> None:
        """Write samples from the next one on into a new recording."""
        self.writer = RecordingWriter(out)

    def finish(self) -> Path | None:
        """Close the recording, if there is one; its path."""
        if self.writer is None:
            return None
        self.writer.finish()
        path, self.writer = self.writer.path, None
        return path

    def silent(self, patience_s: float, since: float) -> str | None:
        """The topic of a sample that was not heard for so long, of wall time; None if all were."""
        now = time.monotonic()
        for key in self.keys:
            if now - max(self.heard.get(key, since), since) > patience_s:
                return self._node.resolve_topic_name(telemetry_name(key, self._names))
        return None

    def _on_message(self, key: str, data: bytes) -> None:
        self.heard[key] = time.monotonic()
        self.heard_first.setdefault(key, self.heard[key])
        if self._sequencer is None or key not in self.keys:
            return
        data = bytes(data)
        self._sequencer.put(key, data, wire.stamp_of(data))

    def _on_part(self, key: str, data: bytes, stamp_ns: int) -> None:
        """One topic's part of a sample; those of one stamp come one after the other."""
        if stamp_ns != self._stamp_ns:
            self._say()
            self._stamp_ns = stamp_ns
        if self.writer is not None:
            self.writer.write(_TOPICS[key].name, data, stamp_ns)
        if key not in self._reading:
            return
        try:
            _, self._values[key] = self._reading[key].unpack(data)
        except CdrError as error:
            self._on_flaw(f"{telemetry_name(key, self._names)}: {error}; expected the joint rod")
            return

    def _say(self) -> None:
        """Hand over the sample whose parts have come; one that lacks a part is not judged by."""
        values, self._values = self._values, {}
        if all(one in values for one in NEEDED):
            reference, velocity = values["reference"]
            (rod,) = values["joint_states"]
            (current,) = values.get("current", [math.nan])
            self._on_sample(Sample(self._stamp_ns * 1e-9, reference, velocity, rod, current))
