"""The message classes behave as rosidl's, and their bytes are those of genuine Jazzy."""

import array
import pickle

import numpy
import pytest
import rclpy
from geometry_msgs.msg import Quaternion, Vector3Stamped
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import Imu, JointState
from std_msgs.msg import Bool, Float64, Header, String
from std_srvs.srv import SetBool


def test_bytes_are_those_of_genuine_jazzy():
    """A JointState serialises to the bytes that genuine rclpy gives."""
    message = JointState(name=["a"], position=[1.0])
    message.header.frame_id = "b"
    expected = (
        "00010000" "00000000" "00000000" "02000000" "62000000" "01000000" "02000000" "61000000"
        "01000000" "000000000000f03f" "00000000" "00000000"
    )  # fmt: skip
    assert serialize_message(message).hex() == expected


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
    try:
        message.position = values
    except AssertionError:
        if "rclpy_cyclone" in rclpy.__file__ or not isinstance(values, numpy.ndarray):
            raise
        pytest.skip("rosidl takes a numpy array only where fields are not checked")
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
