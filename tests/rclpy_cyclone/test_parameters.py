"""Parameters, command lines and parameter files behave as measured on genuine Jazzy."""

import warnings

import pytest
from rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    ParameterDescriptor,
    SetParametersResult,
)
from rclpy._rclpy_pybind11 import RCLError, UnknownROSArgsError
from rclpy.context import Context
from rclpy.exceptions import (
    InvalidParameterException,
    InvalidParameterTypeException,
    InvalidParameterValueException,
    ParameterAlreadyDeclaredException,
    ParameterImmutableException,
    ParameterNotDeclaredException,
    ParameterUninitializedException,
)
from rclpy.parameter import Parameter

FILE = """
/**:
  ros__parameters: {a: 1, deep: {b: 2.5, c: [1, 2, 3]}}
n:
  ros__parameters: {a: 2, flag: yes, off_: "off", s: text, quoted: "12", e: 1e3, fl: .5,
    oct: 010, hex: 0x1F, inf: .inf, strs: [a, b], bools: [true, false], dotted.name: 1}
/ns:
  n2:
    ros__parameters: {z: 9}
other:
  ros__parameters: {a: 77}
"""


def values(node):
    """Return a node's parameters by name, but for those every node has."""
    own = ("use_sim_time", "start_type_description_service")
    return {n: p.value for n, p in node._parameters.items() if n not in own}


def test_parameter_file(make_node, tmp_path):
    """Wildcards, namespaces, nested and dotted names, and the types of plain YAML scalars."""
    file = tmp_path / "p.yaml"
    file.write_text(FILE)
    node = make_node(
        "n",
        ["--params-file", str(file)],
        automatically_declare_parameters_from_overrides=True,
    )
    assert values(node) == {
        "a": 2, "deep.b": 2.5, "deep.c": [1, 2, 3], "flag": True, "off_": "off", "s": "text",
        "quoted": "12", "e": 1000.0, "fl": 0.5, "oct": 8, "hex": 31, "inf": float("inf"),
        "strs": ["a", "b"], "bools": [True, False], "dotted.name": 1,
    }  # fmt: skip
    other = make_node(
        "n2",
        ["--params-file", str(file), "-r", "__ns:=/ns", "-p", "n2:q:=5", "-p", "x:q:=6"],
        automatically_declare_parameters_from_overrides=True,
    )
    assert values(other) == {"a": 1, "deep.b": 2.5, "deep.c": [1, 2, 3], "z": 9}


# What genuine Jazzy (rclpy 7.1.3) makes of ``-p x:=...``
SCALARS = {
    "1": 1, "-5": -5, "+5": 5, "0x10": 16, "0777": 511, "08": 8.0, "1.0": 1.0, "1e3": 1000.0,
    ".5": 0.5, "5.": 5.0, "inf": float("inf"), "-.inf": float("-inf"), "Infinity": float("inf"),
    "true": True, "on": True, "n": False, "Off": False, "abc": "abc", "'5'": "5", "!!str 5": "5",
    "~": "~", "null": "null", "1_000": "1_000", "12:30": "12:30", "2020-01-01": "2020-01-01",
    "1e400": "1e400", "1.5e": "1.5e", "0b1": "0b1", "9223372036854775808": 2.0**63,
    "[1, 2]": [1, 2], "[yes, no]": [True, False], "['1', '2']": ["1", "2"], "[a]": ["a"],
}  # fmt: skip


@pytest.mark.parametrize("text", SCALARS)
def test_types_of_command_line_values(make_node, text):
    """The type of a value on the command line is the one genuine Jazzy gives it."""
    node = make_node(
        "n", ["-p", f"x:={text}"], automatically_declare_parameters_from_overrides=True
    )
    value = node.get_parameter("x").value
    assert value == SCALARS[text] and type(value) is type(SCALARS[text])


@pytest.mark.parametrize(
    "args",
    [
        ["-r"], ["-r", "foo"], ["-r", "a:=b c"], ["-r", "__node:=1x"], ["-r", "__ns:=x"],
        ["-r", "/foo:=/bar/"], ["-p", "x"], ["-p", "x:=["], ["-p", ":=1"], ["-p", "x:="],
        ["-p", "x:=[1, a]"], ["-p", "x:=[1, 2.5]"], ["-p", "x:={a: 1}"], ["-e"],
        ["--params-file", "/there/is/none"], ["--log-level", "loud"],
    ],
)  # fmt: skip
def test_malformed_arguments(args):
    """Malformed ROS arguments raise RCLError, as measured on genuine Jazzy."""
    with pytest.raises(RCLError):
        Context().init(["--ros-args", *args])


@pytest.mark.parametrize("args", [["--bogus"], ["foo:=bar"]])
def test_unknown_arguments(args):
    """ROS arguments that nobody knows raise UnknownROSArgsError."""
    with pytest.raises(UnknownROSArgsError):
        Context().init(["--ros-args", *args])


@pytest.mark.parametrize(
    "text",
    [
        "a: 1", "a:\n  ros__parameters: 3", "a:\n  ros__parameters:\n    x: [1, b]", "- a",
        "a:\n  x: 1", "a:\n  ros__parameters:\n    x:", "{", "ros__parameters:\n  x: 1",
    ],
)  # fmt: skip
def test_malformed_files(tmp_path, text):
    """What is no parameter file raises RCLError, as measured on genuine Jazzy."""
    file = tmp_path / "p.yaml"
    file.write_text(text)
    with pytest.raises(RCLError):
        Context().init(["--ros-args", "--params-file", str(file)])


def test_remapping(make_node):
    """Rules rename topics, services and nodes; rules for other nodes do not."""
    rules = "chat:=talk /abs:=/new ~/priv:=pub m:only:=mine x:only2:=no __node:=mm rel:=~/r"
    args = [part for rule in rules.split() for part in ("-r", rule)]
    args += ["-r", "rosservice://srv:=svc", "-r", "rostopic://srv:=top"]
    node = make_node("m", args)
    names = ["chat", "/chat", "abs", "~/priv", "only2", "srv", "rel", "foo/bar", "~"]
    assert [node.resolve_topic_name(n) for n in names] == [
        "/talk", "/talk", "/new", "/pub", "/only2", "/top", "/mm/r", "/foo/bar", "/mm",
    ]  # fmt: skip
    assert node.resolve_service_name("srv") == "/svc"
    assert node.get_fully_qualified_name() == "/mm"


def test_declaring_and_getting(make_node):
    """Declaration infers the type, which then holds; what is not declared is not there."""
    node = make_node()
    assert node.declare_parameter("a", 1).value == 1
    assert [p.name for p in node.declare_parameters("g", [("p", 1), ("q", 2.0)])] == ["g.p", "g.q"]
    assert sorted(node.get_parameters_by_prefix("g")) == ["p", "q"]
    node.declare_parameter("typed", Parameter.Type.INTEGER)
    with pytest.raises(ParameterAlreadyDeclaredException):
        node.declare_parameter("a", 1)
    with pytest.raises(InvalidParameterException):
        node.declare_parameter("", 1)
    with pytest.raises(ParameterUninitializedException):
        node.get_parameter("typed")
    with pytest.raises(ParameterNotDeclaredException):
        node.get_parameter("x")
    with pytest.raises(ParameterNotDeclaredException):
        node.set_parameters([Parameter("x", value=1)])
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        node.declare_parameter("name_only")
    assert caught
    result = node.set_parameters([Parameter("a", value=1.5)])[0]
    assert not result.successful and result.reason.startswith("Wrong parameter type")
    assert make_node("k", ["-p", "a:=5"]).declare_parameter("a", 1).value == 5
    with pytest.raises(InvalidParameterTypeException):
        make_node("k", ["-p", "a:=5"]).declare_parameter("a", 1.0)


def test_descriptors(make_node):
    """Read-only parameters and ranges are kept."""
    node = make_node()
    node.declare_parameter("ro", 1, ParameterDescriptor(read_only=True))
    assert not node.set_parameters([Parameter("ro", value=2)])[0].successful
    with pytest.raises(ParameterImmutableException):
        node.undeclare_parameter("ro")
    whole = ParameterDescriptor(integer_range=[IntegerRange(from_value=0, to_value=10, step=2)])
    with pytest.raises(InvalidParameterValueException):
        node.declare_parameter("r", 11, whole)
    node.declare_parameter("r", 4, whole)
    tried = node.set_parameters([Parameter("r", value=v) for v in (3, 12, 10)])
    assert [r.successful for r in tried] == [False, False, True]
    real = ParameterDescriptor(
        floating_point_range=[FloatingPointRange(from_value=0.0, to_value=1.0, step=0.25)]
    )
    node.declare_parameter("f", 0.5, real)
    tried = node.set_parameters([Parameter("f", value=v) for v in (0.3, 2.0, 0.75)])
    assert [r.successful for r in tried] == [False, False, True]


def test_callbacks(make_node):
    """Callbacks run in rclpy's order, the last added first, and may refuse."""
    node = make_node()
    node.declare_parameter("a", 1)
    order = []

    def deciding(name):
        def check(parameters):
            order.append(name)
            return SetParametersResult(successful=parameters[0].value != 99, reason="not 99")

        return check

    node.add_pre_set_parameters_callback(lambda ps: (order.append("pre"), ps)[1])
    node.add_on_set_parameters_callback(deciding("on1"))
    node.add_on_set_parameters_callback(deciding("on2"))
    node.add_post_set_parameters_callback(lambda ps: order.append("post"))
    results = node.set_parameters([Parameter("a", value=5), Parameter("a", value=99)])
    assert [(r.successful, r.reason) for r in results] == [(True, ""), (False, "not 99")]
    assert order == ["pre", "on2", "on1", "post", "pre", "on2"]
    assert node.get_parameter("a").value == 5


def test_parameters_of_another_node(make_node, spin):
    """A parameter client lists, gets and sets another node's parameters."""
    from rclpy.parameter_client import AsyncParameterClient

    node = make_node("owner")
    node.declare_parameter("gain", 2.0)
    client_node = make_node("user", context=node.context)
    client = AsyncParameterClient(client_node, "/owner")
    assert client.wait_for_services(30.0)
    listed, got = client.list_parameters(["gain"]), client.get_parameters(["gain"])
    changed = client.set_parameters([Parameter("gain", value=3.0), Parameter("gain", value="x")])
    done = [listed, got, changed]
    assert spin(lambda: all(f.done() for f in done), node, client_node)
    assert listed.result().result.names == ["gain"]
    assert got.result().values[0].double_value == 2.0
    assert [r.successful for r in changed.result().results] == [True, False]
    assert node.get_parameter("gain").value == 3.0
