"""The message classes behave as rosidl's, and their bytes are those of genuine Jazzy."""

import array
import copy
import pickle
import random

import numpy
import pytest
from geometry_msgs.msg import Quaternion, Vector3Stamped
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import Imu, JointState
from std_msgs.msg import Bool, Float64, Header, String
from std_srvs.srv import SetBool

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


def test_bytes_are_those_of_genuine_jazzy():
    """A JointState serialises to the bytes that genuine rclpy gives."""
    message = JointState(name=["a"], position=[1.0])
    message.header.frame_id = "b"
    expected = (
        "00010000" "00000000" "00000000" "02000000" "62000000" "01000000" "02000000" "61000000"
        "01000000" "000000000000f03f" "00000000" "00000000"
    )  # fmt: skip
    assert serialize_message(message).hex() == expected


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


def test_broken_bytes_are_refused():
    """Bytes that end too early raise, whatever length they claim."""
    whole = serialize_message(JointState(name=["abc"], position=[1.0]))
    for end in range(4, len(whole) - 4):
        with pytest.raises(RuntimeError):
            deserialize_message(whole[:end], JointState)


def test_defaults_and_types_of_fields():
    """Fields have rosidl's defaults: arrays of numbers, numpy for fixed ones, w = 1."""
    message = JointState()
    assert message.position == array.array("d") and message.name == []
    assert isinstance(Imu().orientation_covariance, numpy.ndarray)
    assert Quaternion().w == 1.0
    assert SetBool.Request().data is False
    assert String.get_fields_and_field_types() == {"data": "string"}
    assert JointState.get_fields_and_field_types()["position"] == "sequence<double>"


@pytest.mark.parametrize("values", [[1.0, 2.0], (1.0, 2.0), numpy.array([1.0, 2.0])])
def test_number_sequences_take_what_holds_numbers(values):
    """A list, a tuple and a numpy array become an array.array on assignment."""
    message = JointState()
    message.position = values
    assert message.position == array.array("d", [1.0, 2.0])


@pytest.mark.parametrize(
    "wrong",
    [
        lambda: Float64(data=1),
        lambda: Float64(data="1"),
        lambda: Float64(value=1.0),
        lambda: String(data=b"x"),
        lambda: Bool(data=1),
        lambda: Header(stamp=3),
        lambda: JointState(name="abc"),
        lambda: JointState(name=[1]),
        lambda: setattr(JointState(), "position", [1, 2]),
        lambda: setattr(JointState(), "position", array.array("f", [1.0])),
        lambda: setattr(Header().stamp, "sec", 2**31),
        lambda: setattr(Header().stamp, "nanosec", -1),
        lambda: setattr(Imu(), "orientation_covariance", [0.0]),
    ],
)
def test_wrong_values_are_refused(wrong):
    """A value of the wrong type or range, and an unknown field, raise AssertionError."""
    with pytest.raises(AssertionError):
        wrong()


def test_messages_print_compare_and_pickle_as_rosidls():
    """repr, ==, hash and pickle are those of rosidl's classes."""
    message = JointState(name=["a"], position=[1.0])
    assert repr(message) == (
        "sensor_msgs.msg.JointState(header=std_msgs.msg.Header(stamp=builtin_interfaces.msg."
        "Time(sec=0, nanosec=0), frame_id=''), name=['a'], position=[1.0], velocity=[], effort=[])"
    )
    assert message == JointState(name=["a"], position=[1.0]) != JointState()
    assert pickle.loads(pickle.dumps(message)) == message
    with pytest.raises(TypeError):
        hash(message)
    with pytest.raises(AttributeError):
        Vector3Stamped().x = 1.0
