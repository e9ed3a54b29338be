"""Recordings out: MCAP files, alone or in rosbag2 folder bags, that `ros2 bag` opens as is."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any

import yaml

from .. import __version__
from ..errors import InputError
from . import unclosed
from .atomic import replacing
from .messages import definition, type_hash
from .signals import FOREIGN_SIGNALS, SIGNALS, Recording
from .topics import TOPICS, TopicSpec

PROFILE = "ros2"
# Closed by size alone, so that the content determines the bytes. At 1 kHz telemetry a chunk holds
# two thirds of a second: that much a killed recorder loses.
CHUNK_BYTES = 256 * 1024
MESSAGE_OVERHEAD = 31  # opcode, length, channel, sequence and two times of a message record
METADATA_VERSION = 9  # of metadata.yaml, as Jazzy's rosbag2 writes it
FOREVER = {"sec": 9223372036, "nsec": 854775807}  # RMW_DURATION_INFINITE
QOS: dict[str, Any] = {
    "history": "keep_last",
    "depth": 10,
    "reliability": "reliable",
    "durability": "volatile",
    "deadline": FOREVER,
    "lifespan": FOREVER,
    "liveliness": "automatic",
    "liveliness_lease_duration": FOREVER,
    "avoid_ros_namespace_conventions": False,
}


class _PlainDumper(yaml.SafeDumper):
    """YAML without `&anchor`s."""

    def ignore_aliases(self, data: Any) -> bool:
        return True


def _yaml(data: Any) -> str:
    return yaml.dump(data, Dumper=_PlainDumper, sort_keys=False)


class RecordingWriter:
    """Writes CDR messages as they come into a new recording.

    Args:
        path: `NAME.mcap` for a single file; anything else becomes a rosbag2 folder bag,
            `NAME/NAME_0.mcap` with a metadata.yaml. Missing parent folders are created.
        topics: the topics that may be written. Each becomes a channel whether or not a message
            comes.
        overwrite: replace what stands at `path`, provided that it is a recording.
        chunk_bytes: uncompressed size at which a chunk is closed, compressed (zstd) and handed to
            the operating system. A process that is killed loses at most the open chunk; the rest
            is a valid file without an index (see `unclosed`).

    Raises:
        InputError: the target exists and may not be replaced, or cannot be created.

    Used as a context manager, or ended by `finish()`. Leaving the context on an exception finishes
    the file too: what was recorded until then is kept.
    """

    def __init__(
        self,
        path: str | Path,
        *,
        topics: Sequence[TopicSpec] = TOPICS,
        overwrite: bool = False,
        chunk_bytes: int = CHUNK_BYTES,
    ) -> None:
        from mcap.writer import LIBRARY_IDENTIFIER, CompressionType, Writer

        self.path = Path(path)
        self.topics = tuple(topics)
        self.is_folder = self.path.suffix != ".mcap"
        self.file = self.path / f"{self.path.name}_0.mcap" if self.is_folder else self.path
        try:
            _make_room(self.path, overwrite=overwrite)
            self.file.parent.mkdir(parents=True, exist_ok=True)
            self._stream = self.file.open("xb")
        except OSError as error:
            raise InputError(f"{self.file}: cannot be created: {error.strerror}") from None
        # mcap's own limit is set out of reach: `flush` closes chunks, at the size asked for, and
        # passes them on to the system at once.
        self._writer = Writer(
            self._stream, chunk_size=2**62, compression=CompressionType.ZSTD, use_chunking=True
        )
        self._writer.start(PROFILE, f"ecyl_ros/{__version__} {LIBRARY_IDENTIFIER}")
        self._chunk_bytes = chunk_bytes
        self._pending_bytes = 0
        self._finished = False
        self._channels = self._register()
        with self._saying_why():
            self._writer.flush()
            unclosed.put(self._stream)
        self._counts = dict.fromkeys(self._channels, 0)
        self._first_ns: int | None = None
        self._last_ns = 0

    def _register(self) -> dict[str, int]:
        schemas: dict[str, int] = {}
        channels: dict[str, int] = {}
        for topic in self.topics:
            if topic.type not in schemas:
                schemas[topic.type] = self._writer.register_schema(
                    topic.type, "ros2msg", definition(topic.type).encode()
                )
            channels[topic.name] = self._writer.register_channel(
                topic.name,
                "cdr",
                schemas[topic.type],
                {
                    "offered_qos_profiles": _yaml([QOS]),
                    "topic_type_hash": type_hash(topic.type),
                },
            )
        return channels

    def write(self, topic: str, cdr: bytes, stamp_ns: int) -> None:
        """Append one message; its log and publish time are the stamp.

        Raises InputError where the file cannot be written, such as on a full disk.

        Args:
            topic: name of one of the writer's topics; KeyError for another.
            cdr: the serialised message, with its encapsulation header.
            stamp_ns: sample instant, ns, not negative.
        """
        channel = self._channels[topic]
        self._writer.add_message(
            channel,
            log_time=stamp_ns,
            data=cdr,
            publish_time=stamp_ns,
            sequence=self._counts[topic],
        )
        self._counts[topic] += 1
        if self._first_ns is None:
            self._first_ns = self._last_ns = stamp_ns
        self._first_ns = min(self._first_ns, stamp_ns)
        self._last_ns = max(self._last_ns, stamp_ns)
        self._pending_bytes += len(cdr) + MESSAGE_OVERHEAD
        if self._pending_bytes >= self._chunk_bytes:
            with self._saying_why():
                self._writer.flush()
                unclosed.put(self._stream)
            self._pending_bytes = 0

    @property
    def message_count(self) -> int:
        """Messages written so far."""
        return sum(self._counts.values())

    def finish(self) -> None:
        """Close the last chunk, write the index, and for a folder its metadata.yaml."""
        if self._finished:
            return
        self._finished = True
        with self._saying_why():
            with self._stream:
                self._writer.finish()
            if self.is_folder:
                text = _yaml({"rosbag2_bagfile_information": self._metadata()})
                (self.path / "metadata.yaml").write_text(text, encoding="utf-8")

    @contextlib.contextmanager
    def _saying_why(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:  # a full disk, most of the time
            raise InputError(f"{self.file}: cannot be written: {error.strerror}") from None

    def _metadata(self) -> dict[str, Any]:
        span = {
            "starting_time": {"nanoseconds_since_epoch": self._first_ns or 0},
            "duration": {"nanoseconds": self._last_ns - (self._first_ns or 0)},
            "message_count": self.message_count,
        }
        topics = [
            {
                "topic_metadata": {
                    "name": topic.name,
                    "type": topic.type,
                    "serialization_format": "cdr",
                    "offered_qos_profiles": [QOS],
                    "type_description_hash": type_hash(topic.type),
                },
                "message_count": self._counts[topic.name],
            }
            for topic in self.topics
        ]
        return {
            "version": METADATA_VERSION,
            "storage_identifier": "mcap",
            **span,
            "topics_with_message_count": topics,
            "compression_format": "",
            "compression_mode": "",
            "relative_file_paths": [self.file.name],
            "files": [{"path": self.file.name, **span}],
            "custom_data": None,
            "ros_distro": "jazzy",
        }

    def __enter__(self) -> RecordingWriter:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        # Where writing has failed, finishing will too: the first reason is the one to hear.
        with contextlib.suppress(InputError) if error is not None else contextlib.nullcontext():
            self.finish()


def write_recording(
    recording: Recording,
    path: str | Path,
    *,
    topics: Sequence[TopicSpec] = TOPICS,
    overwrite: bool = False,
) -> tuple[str, ...]:
    """Write a recording's arrays. Identical input gives identical bytes.

    Samples follow each other in stamp order, one sample's topics in the order of `topics`. A topic
    of which no signal was measured is left out, and so is an optional joint; anything else
    unmeasured is written as NaN.

    Returns:
        Signals that were measured but that no topic carries, such as an injected force.

    Raises:
        InputError: as `RecordingWriter`, for a recording without samples, or one whose stamps do
            not fit a ROS time (0 to 2**31 s).
    """
    from .cdr import NANOSECONDS, encode

    if not len(recording):
        raise InputError(f"{path}: nothing to write: the recording holds no samples")
    if recording.stamp_ns[0] < 0 or recording.stamp_ns[-1] >= 2**31 * NANOSECONDS:
        raise InputError(f"{path}: stamps must lie between 0 and 2**31 s to fit a ROS time")
    written: list[TopicSpec] = []
    columns: list[list[bytes]] = []
    for topic in topics:
        measured = {p: s for p, s in topic.signals.items() if recording.has(s)}
        if not measured:
            continue
        joints = topic.joints + tuple(
            joint
            for joint in topic.optional_joints
            if any(path.rpartition(".")[0] == joint for path in measured)
        )
        values = {
            path: recording.signal(signal)
            for path, signal in topic.signals.items()
            if not topic.joints or path.rpartition(".")[0] in joints
        }
        written.append(topic)
        columns.append(encode(topic.type, topic.frame_id, joints, recording.stamp_ns, values))
    if not written:
        raise InputError(f"{path}: nothing to write: the recording holds no measured signal")
    carried = {signal for topic in topics for signal in topic.signals.values()}
    held = (name for name in (*SIGNALS, *FOREIGN_SIGNALS) if recording.has(name))
    homeless = tuple(name for name in held if name not in carried)

    def fill(target: Path, *, overwrite: bool) -> None:
        with RecordingWriter(target, topics=written, overwrite=overwrite) as writer:
            for i, stamp in enumerate(recording.stamp_ns.tolist()):
                for topic, messages in zip(written, columns, strict=True):
                    writer.write(topic.name, messages[i], stamp)

    target = Path(path)
    if target.suffix == ".mcap":
        _check_room(target, overwrite=overwrite)
        with replacing(target) as temporary:
            try:
                fill(temporary, overwrite=True)
            except InputError as error:
                raise InputError(str(error).replace(str(temporary), str(target))) from None
        return homeless
    try:
        fill(target, overwrite=overwrite)
    except InputError:
        # Half a bag is no bag. A target that was refused still holds what it held.
        if (target / f"{target.name}_0.mcap").exists() and not (target / "metadata.yaml").exists():
            _clear(target)
            target.rmdir()
        raise
    return homeless


def _make_room(path: Path, *, overwrite: bool) -> None:
    """Refuse an existing target, or remove it where that was asked for and it is a recording."""
    _check_room(path, overwrite=overwrite)
    if path.is_dir():
        _clear(path)
    elif path.exists() or path.is_symlink():
        path.unlink()


def _check_room(path: Path, *, overwrite: bool) -> None:
    if not path.exists() and not path.is_symlink():
        return
    if not overwrite:
        raise InputError(f"{path}: exists already; give another name or ask to overwrite it")
    if path.suffix == ".mcap":
        if not path.is_file():
            raise InputError(f"{path}: is no file and will not be overwritten")
        return
    if not path.is_dir():
        raise InputError(f"{path}: is no bag folder and will not be overwritten")
    strangers = [entry.name for entry in sorted(path.iterdir()) if not _of_a_bag(entry)]
    if strangers:
        raise InputError(f"{path}: holds {strangers[0]}, so is no mere bag: not overwritten")


def _of_a_bag(entry: Path) -> bool:
    return entry.name == "metadata.yaml" or entry.suffix == ".mcap"


def _clear(folder: Path) -> None:
    for entry in folder.iterdir():
        if _of_a_bag(entry):
            entry.unlink(missing_ok=True)
