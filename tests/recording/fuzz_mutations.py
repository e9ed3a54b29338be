"""A good file changed at random: by bytes, by words, or within its messages."""

from __future__ import annotations

import re
import tempfile
from pathlib import Path

import numpy as np
import zstandard
from foreign_bags import write_sqlite
from mcap.writer import CompressionType, Writer

from ecyl_ros.recording.bag import read_bag
from ecyl_ros.recording.bag_contents import in_time_order

_TEXTS = ("csv", "tables", "drive", "map", "metadata", "motion", "joint", "diagnosis")
WORDS = (
    *(b"counts", b"16bit", b"signed 16bit", b"rev", b"4096", b"counts_per_rev", b"wrap", b"[foo]"),
    *(b"2024-05-01T12:00:00Z", b"9999-12-31 00:00", b"iso8601", b"//", b"#", b"[deg]", b"(s)"),
    *(b"nan", b"1e999", b"-1", b"0", b'"', b"[", b"]", b"{", b"}", b"*a", b"&a ", b"\n", b","),
    *(b";", b"9999999999999999999", b"!!python/object:x", b"0x1", b": ", b"\t", b"~", b"true"),
    *(b"", b" ", b"mm", b"rad", b"header", b"bag", b"'", b"\xc2\xb5", b"|", b"- ", b"?", b"%"),
)


def mutated(kind: str, data: bytes, others: list[bytes], random: np.random.Generator) -> bytes:
    """A good file of a kind, changed at random.

    Text is changed by words as often as by bytes. Of bags every other one is changed in a message,
    a definition or a name and put together again, so that no checksum gives it away.
    """
    if kind == "packed" and random.random() < 0.5:  # what is in the frame, not the frame
        return zstandard.compress(mutated("mcap", zstandard.decompress(data), [data], random))
    if kind in _TEXTS and random.random() < 0.7:
        return _reworded(data, random)
    if kind in ("mcap", "sqlite3") and random.random() < 0.5:
        return _remade(kind, data, random)
    out = data
    for _ in range(int(random.integers(1, 4))):
        out = _changed(out, others, random)
    return out


def _changed(data: bytes, others: list[bytes], random: np.random.Generator) -> bytes:
    """One change: bytes, extremes, cuts, repeats, pieces of other files."""
    out = bytearray(data)
    size = max(len(out), 1)
    at = int(random.integers(0, size))
    run = max(int(min(random.geometric(0.1), size - at)), 1)
    how = int(random.integers(0, 8))
    if how == 0:
        out[at : at + 1] = bytes([int(random.integers(0, 256))])
    elif how == 1:
        extreme = (b"\xff" * 8, b"\0" * 8, b"\x7f" + b"\xff" * 7, b"\xff\xff\xff\x7f")
        chosen = extreme[int(random.integers(0, len(extreme)))]
        out[at : at + len(chosen)] = chosen
    elif how == 2:
        del out[at : at + run]
    elif how == 3:
        out[at:at] = random.integers(0, 256, run, dtype=np.uint8).tobytes()
    elif how == 4:
        out[at:at] = bytes(out[at : at + 10 * run])
    elif how == 5:
        other = others[int(random.integers(0, len(others)))]
        place = int(random.integers(0, max(len(other), 1)))
        out[at : at + run] = other[place : place + run]
    elif how == 6 and random.random() < 0.2:
        del out[at:]
    elif out:
        out[at] ^= 1 << int(random.integers(0, 8))
    return bytes(out)


def _reworded(data: bytes, random: np.random.Generator) -> bytes:
    """One or two words, lines or cells of a text changed."""
    parts = re.split(rb"([\s,;:\[\]{}<>=/]+)", data)
    for _ in range(int(random.integers(1, 3))):
        at = int(random.integers(0, len(parts)))
        how = int(random.integers(0, 5))
        if how == 0:
            parts[at] = WORDS[int(random.integers(0, len(WORDS)))]
        elif how == 1:
            parts[at] = parts[int(random.integers(0, len(parts)))]
        elif how == 2:
            parts[at] += WORDS[int(random.integers(0, len(WORDS)))]
        elif how == 3:
            parts[at] = b""
        else:
            digits = bytes(48 + int(one) for one in random.integers(0, 10, random.integers(1, 25)))
            parts[at] = digits
    return b"".join(parts)


def _remade(kind: str, data: bytes, random: np.random.Generator) -> bytes:
    """A bag whose messages, definitions or names were changed before it was written."""
    with tempfile.TemporaryDirectory() as name:
        suffix = ".mcap" if kind == "mcap" else ".db3"
        source, target = Path(name, f"source{suffix}"), Path(name, f"target{suffix}")
        source.write_bytes(data)
        bag = read_bag(source)
        topics = list(bag.topics.values())
        victim = topics[int(random.integers(0, len(topics)))]
        what = random.random()
        if what < 0.6:
            for _ in range(int(random.integers(1, 4))):
                i = int(random.integers(0, len(victim.data)))
                victim.data[i] = _changed(victim.data[i], victim.data, random)
        elif what < 0.75:
            # The same change in every message: another, valid structure, or none.
            place, value = int(random.integers(0, 40)), int(random.integers(0, 256))
            victim.data = [one[:place] + bytes([value]) + one[place + 1 :] for one in victim.data]
        elif what < 0.9:
            text = victim.definition.encode()
            text = (
                _reworded(text, random) if random.random() < 0.7 else _changed(text, [text], random)
            )
            victim.definition = text.decode("utf-8", "replace")
        else:
            places = random.integers(0, len(victim.log_time_ns), 5)
            for i in places.tolist():
                victim.log_time_ns[i] = int(random.integers(0, 2**62))
        if kind == "sqlite3":
            write_sqlite(bag, target)
        else:
            with target.open("wb") as file:
                writer = Writer(file, compression=CompressionType.NONE)
                writer.start("ros2", "test")
                ids = {}
                for topic in topics:
                    schema = writer.register_schema(
                        topic.type, topic.definition_encoding, topic.definition.encode()
                    )
                    ids[topic.name] = writer.register_channel(topic.name, "cdr", schema)
                for stamp, topic_name, message in in_time_order(bag):
                    writer.add_message(ids[topic_name], stamp, message, stamp)
                writer.finish()
        return target.read_bytes()
