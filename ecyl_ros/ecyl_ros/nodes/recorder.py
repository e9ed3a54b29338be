"""The recorder node: the contract's topics into an MCAP file, as bytes, in canonical order."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from builtin_interfaces.msg import Time
from geometry_msgs.msg import Vector3Stamped
from sensor_msgs.msg import JointState

from ..drive.engine import sample_count
from ..drive.telemetry import tick_stamp_ns
from ..errors import InputError
from ..recording.sequencer import SampleSequencer
from ..recording.topics import JOINT_STATE, TOPICS, renamed
from ..recording.writer import RecordingWriter
from . import wire
from .drive_node import DriveNode
from .run_node import run_node

_CLASSES = {JOINT_STATE: JointState}
LAST_PATIENCE_S = 2.0  # for the last voltage and reference after the last joint state


class Recorder(DriveNode):
    """Writes telemetry as it comes; ends by itself when `duration` is recorded.

    Stopped by a signal it closes the file; killed, it loses the last open chunk at most.
    """

    batch_s = 2e-3

    def __init__(self, **options) -> None:
        super().__init__(
            "recorder",
            {
                "out": ("", "file NAME.mcap or folder to record into"),
                "overwrite": (False, "replace an existing recording"),
                "duration": (0.0, "s to record; 0: until stopped"),
            },
            **options,
        )
        out = self.option("out")
        if not out:
            raise InputError("node recorder: out is missing, expected a file NAME.mcap to write")
        names = {topic.key: self.resolve_topic_name(topic.name.lstrip("/")) for topic in TOPICS}
        topics = renamed(names)
        self._writer = RecordingWriter(Path(out), topics=topics, overwrite=self.option("overwrite"))
        self._sequencer = SampleSequencer(
            self._writer.write, topics=[topic.name for topic in topics]
        )
        duration = self.option("duration")
        self._samples = sample_count(self.drive, duration) if duration else None
        self._joint_states = names["joint_states"]
        self._last_ns: int | None = None  # stamp of the last sample wanted
        self._seen_last = False
        self.create_subscription(Time, wire.EPOCH, self._on_epoch, wire.latched())
        for topic in topics:
            self.create_subscription(
                _CLASSES.get(topic.type, Vector3Stamped),
                topic.name,
                partial(self._on_message, topic.name),
                wire.lossless(),
                raw=True,
            )

    def _on_epoch(self, message: Time) -> None:
        """A run begins, or has begun: now the stamp of its last sample is known."""
        if self._samples is not None:
            last_tick = (self._samples - 1) * self.drive.telemetry_every
            rate = self.drive.controller.rate
            self._last_ns = tick_stamp_ns(last_tick, rate, wire.to_ns(message))

    def _on_message(self, topic: str, data: bytes) -> None:
        self.heard_partner()
        stamp_ns = wire.stamp_of(data)
        self._sequencer.put(topic, bytes(data), stamp_ns)
        if self._last_ns is None:
            return
        self._seen_last |= topic == self._joint_states and stamp_ns >= self._last_ns
        if self._sequencer.released_ns >= self._last_ns:
            self.finish(0, f"recorded {self._samples} samples in {self._writer.path}")

    def while_waiting(self) -> None:
        """The plant is through, and what a topic still owes will not come."""
        if self._seen_last and self.silent_s() > LAST_PATIENCE_S:
            self.finish(0, f"recorded {self._writer.path}, some samples incomplete")

    def waiting_for(self) -> str | None:
        """Any telemetry at all."""
        return "telemetry on " + self.resolve_topic_name(wire.JOINT_STATES)

    def close(self) -> None:
        """Write what waits and close the file."""
        self._sequencer.finish()
        self._writer.finish()
        odd = self._sequencer
        if odd.incomplete or odd.late or odd.duplicates:
            self.last_words(
                f"{self._writer.path}: {odd.incomplete} samples lack a topic, {odd.late} messages "
                f"came late, {odd.duplicates} came twice"
            )


def main(args: list[str] | None = None) -> int:
    """Entry point of `recorder`."""
    return run_node(Recorder, args)
