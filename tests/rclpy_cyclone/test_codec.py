"""The stand-in's own codec: type hashes, random content against rosbags, copies, byte order."""

import array
import copy
import random

import numpy
import pytest
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import JointState

pytest.importorskip("rclpy_cyclone.types", reason="genuine rclpy has rosidl's codec, not this one")

from rclpy_cyclone.types import cdr, classes, copying, store

ALL = sorted(n for n in store.names() if n not in classes.services.DEFINITIONS)


def test_hashes_are_those_of_genuine_jazzy():
    """The RIHS01 hashes are those that genuine Jazzy announces."""
    assert store.type_hash("sensor_msgs/msg/JointState") == (
        "RIHS01_a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e"
    )
    assert store.type_hash("std_msgs/msg/String") == (
        "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18"
    )


def fill(field, rng):
    """Return a random value of a field."""
    if field.kind != "one":
        single = store.Field("one", field.base, field.nested, 0, field.text_bound)
        count = field.length if field.kind == "array" else rng.randrange(min(field.length or 4, 4))
        values = [fill(single, rng) for _ in range(count)]
        if field.base in store.TYPECODES and not field.nested:
            code = store.TYPECODES[field.base]
            return numpy.array(values, code) if field.kind == "array" else array.array(code, values)
        return values
    if field.nested:
        return filled(field.base, rng)
    if field.base == "string":
        return "".join(rng.choice("aé字 ") for _ in range(rng.randrange(6)))
    if field.base == "bool":
        return rng.random() < 0.5
    if field.base == "byte":
        return bytes([rng.randrange(256)])
    if field.base.startswith("float"):
        return float(numpy.float32(rng.uniform(-9, 9)))
    return rng.randrange(128)


def filled(name, rng):
    """Return a message with random content."""
    return classes.message_class(name)(**{n: fill(f, rng) for n, f in store.fields(name)})


def rosbags_twin(message):
    """Return the same content as an object of rosbags."""
    types = store.typestore()
    name = message._ros_name
    values = {}
    for field_name, field in store.fields(name):
        value = getattr(message, field_name)
        if field.nested:
            value = rosbags_twin(value) if field.kind == "one" else [rosbags_twin(v) for v in value]
        elif field.base in store.TYPECODES and field.kind != "one":
            value = numpy.array(value, store.TYPECODES[field.base])
        elif field.base == "bool" and field.kind != "one":
            value = numpy.array(value, bool)
        elif field.base == "byte" and field.kind == "one":
            value = int.from_bytes(value, signed=True, byteorder="little")
        elif field.base == "byte":
            value = numpy.frombuffer(b"".join(value), numpy.int8)
        values[field_name] = value
    if not store.fields(name):
        values[store.EMPTY] = 0
    return types.types[name](**values)


@pytest.mark.parametrize("name", [n for n in ALL if "/msg/" in n])
def test_codec_agrees_with_rosbags(name):
    """Random content of every message serialises as rosbags does, and comes back equal."""
    rng = random.Random(name)
    for _ in range(5):
        message = filled(name, rng)
        ours = bytes(cdr.serialise(message))
        theirs = bytes(store.typestore().serialize_cdr(rosbags_twin(message), name))
        assert ours == theirs
        assert cdr.deserialise(ours, type(message)) == message


@pytest.mark.parametrize("name", ALL)
def test_copies_are_equal_and_apart(name):
    """A copy of a random message equals it, and a change to one does not reach the other."""
    message = filled(name, random.Random(name))
    twin = copying.copier(name)(message)
    assert twin == message and twin is not message
    assert copy.deepcopy(message) == message
    for field_name, field in store.fields(name):
        if field.nested or field.kind != "one":
            assert getattr(twin, field_name) is not getattr(message, field_name)


def test_big_endian_bytes_are_read():
    """A big-endian representation (DDS allows it) gives the same message."""
    store_ = store.typestore()
    message = JointState(name=["a", "bc"], position=[1.0, -2.0])
    data = bytes(
        store_.serialize_cdr(rosbags_twin(message), message._ros_name, little_endian=False)
    )
    assert deserialize_message(data, JointState) == message
