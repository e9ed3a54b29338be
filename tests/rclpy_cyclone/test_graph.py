"""Messages, parameters and services, within a process, between processes, and on the wire."""

import struct
import time

import pytest
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.event_handler import PublisherEventCallbacks
from rclpy.executors import MultiThreadedExecutor, SingleThreadedExecutor
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.wait_for_message import wait_for_message
from sensor_msgs.msg import JointState
from std_msgs.msg import String
from std_srvs.srv import SetBool, Trigger

ECHO = """
import rclpy, sys
from rclpy.node import Node
from rclpy.executors import ExternalShutdownException
from sensor_msgs.msg import JointState
from std_srvs.srv import SetBool
rclpy.init()
node = Node("echo")
node.declare_parameter("gain", 2.0)
pub = node.create_publisher(JointState, "back", 10)
node.create_subscription(JointState, "forth", pub.publish, 10)
def serve(request, response):
    response.success = request.data
    response.message = "served"
    return response
node.create_service(SetBool, "set", serve)
ready = node.create_timer(0.0, lambda: (ready.cancel(), print("ready", flush=True)))
try:
    rclpy.spin(node)
except (KeyboardInterrupt, ExternalShutdownException) as end:
    print(type(end).__name__, flush=True)
"""


def test_delivery_in_process_is_a_copy_made_at_publication(make_node, spin):
    """A subscriber gets what was published, whatever becomes of the message afterwards."""
    node = make_node()
    got = []
    node.create_subscription(JointState, "t", got.append, 10)
    pub = node.create_publisher(JointState, "t", 10)
    message = JointState(name=["a"], position=[1.0])
    pub.publish(message)
    message.position[0] = 2.0
    message.name.append("b")
    pub.publish(message)
    assert spin(lambda: len(got) == 2, node)
    assert [list(m.position) for m in got] == [[1.0], [2.0]]
    assert got[0].name == ["a"]


def test_depth_drops_the_oldest(make_node, spin):
    """KEEP_LAST keeps as many messages as its depth, the newest."""
    node = make_node()
    got = []
    node.create_subscription(String, "t", lambda m: got.append(m.data), 2)
    pub = node.create_publisher(String, "t", 10)
    for k in range(5):
        pub.publish(String(data=str(k)))
    assert spin(lambda: len(got) >= 2, node)
    spin(lambda: False, node, seconds=0.1)
    assert got == ["3", "4"]


def test_transient_local_reaches_late_subscriptions(make_node, spin):
    """A late transient local subscription gets the last messages, a volatile one none."""
    node = make_node()
    profile = QoSProfile(depth=2, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    pub = node.create_publisher(String, "t", profile)
    for k in range(4):
        pub.publish(String(data=str(k)))
    late, volatile = [], []
    node.create_subscription(String, "t", lambda m: late.append(m.data), profile)
    node.create_subscription(String, "t", lambda m: volatile.append(m.data), 10)
    assert spin(lambda: len(late) == 2, node)
    assert late == ["2", "3"] and volatile == []


def test_incompatible_qos_is_told_and_not_served(make_node, spin):
    """A best effort publisher and a reliable subscription do not meet, and the publisher hears."""
    node = make_node()
    told, got = [], []
    best_effort = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
    events = PublisherEventCallbacks(incompatible_qos=told.append)
    pub = node.create_publisher(String, "t", best_effort, event_callbacks=events)
    node.create_subscription(String, "t", got.append, 1)
    pub.publish(String())
    assert spin(lambda: bool(told), node)
    assert told[0].total_count == 1 and told[0].last_policy_kind.name.endswith("RELIABILITY")
    assert pub.get_subscription_count() == 0 and got == []


def test_raw_subscription_and_publication(make_node, spin):
    """``raw`` gives CDR bytes, and such bytes can be published."""
    node = make_node()
    raw, whole = [], []
    node.create_subscription(String, "t", raw.append, 10, raw=True)
    node.create_subscription(String, "t", lambda m, info: whole.append((m, info)), 10)
    pub = node.create_publisher(String, "t", 10)
    pub.publish(String(data="hi"))
    pub.publish(bytes.fromhex("0001000003000000686f00"))
    assert spin(lambda: len(raw) == 2 and len(whole) == 2, node)
    # Some middlewares pad what they hand over.
    assert raw[0].rstrip(b"\0") == bytes.fromhex("00010000030000006869")
    assert [m.data for m, _ in whole] == ["hi", "ho"]
    assert whole[0][1]["source_timestamp"] <= time.time_ns()


def test_messages_services_and_parameters_between_processes(make_node, spin, other_process):
    """Another process echoes messages once each, beside a local subscription, and serves."""
    process = other_process(ECHO)
    assert process.stdout.readline() == "ready\n"
    node = make_node("here")
    back, local = [], []
    node.create_subscription(JointState, "back", back.append, 10)
    node.create_subscription(JointState, "forth", local.append, 10)
    pub = node.create_publisher(JointState, "forth", 10)
    client = node.create_client(SetBool, "set")
    assert client.wait_for_service(30.0)
    assert node.wait_for_node("/echo", 30.0)
    assert spin(lambda: pub.get_subscription_count() == 2, node)
    assert spin(lambda: node.count_publishers("back") == 1, node)
    for k in range(20):
        pub.publish(JointState(name=["a"], position=[float(k)]))
        assert spin(lambda k=k: len(back) > k and len(local) > k, node)
    assert [m.position[0] for m in back] == [float(k) for k in range(20)]
    assert len(local) == 20
    future = client.call_async(SetBool.Request(data=True))
    assert spin(future.done, node)
    assert future.result().message == "served"
    from rcl_interfaces.srv import GetParameters

    values = node.create_client(GetParameters, "/echo/get_parameters")
    assert values.wait_for_service(30.0)
    future = values.call_async(GetParameters.Request(names=["gain"]))
    assert spin(future.done, node)
    assert future.result().values[0].double_value == 2.0


@pytest.mark.parametrize(
    ("signal", "exception"),
    [("SIGINT", "KeyboardInterrupt"), ("SIGTERM", "ExternalShutdownException")],
)
def test_signals_end_spin(other_process, signal, exception):
    """SIGINT raises KeyboardInterrupt out of spin, SIGTERM ExternalShutdownException."""
    import signal as signals

    process = other_process(ECHO)
    assert process.stdout.readline() == "ready\n"
    time.sleep(0.3)  # let it go to sleep in spin
    process.send_signal(getattr(signals, signal))
    assert process.communicate(timeout=60)[0].strip().endswith(exception)
    assert process.returncode == 0


def test_what_plain_dds_sees(make_node, domain):
    """A plain Cyclone participant finds rmw's names, types, USER_DATA and discovery info."""
    pytest.importorskip("cyclonedds", reason="looks with the cyclonedds package, not part of ROS 2")
    from dataclasses import dataclass

    from cyclonedds.builtin import (
        BuiltinDataReader,
        BuiltinTopicDcpsParticipant,
        BuiltinTopicDcpsPublication,
    )
    from cyclonedds.domain import DomainParticipant
    from cyclonedds.idl import IdlStruct, types
    from cyclonedds.qos import Policy, Qos
    from cyclonedds.sub import DataReader
    from cyclonedds.topic import Topic

    @dataclass
    class Gid(IdlStruct, typename="rmw_dds_common.msg.dds_.Gid_"):
        data: types.array[types.uint8, 16]

    @dataclass
    class Entities(IdlStruct, typename="rmw_dds_common.msg.dds_.NodeEntitiesInfo_"):
        node_namespace: types.bounded_str[256]
        node_name: types.bounded_str[256]
        reader_gid_seq: types.sequence[Gid]
        writer_gid_seq: types.sequence[Gid]

    @dataclass
    class Info(IdlStruct, typename="rmw_dds_common.msg.dds_.ParticipantEntitiesInfo_"):
        gid: Gid
        node_entities_info_seq: types.sequence[Entities]

    node = make_node("wire", namespace="/ns")
    pub = node.create_publisher(JointState, "joints", 10)
    plain = DomainParticipant(domain)
    quality = Qos(Policy.Reliability.Reliable(10**9), Policy.Durability.TransientLocal)
    reader = DataReader(plain, Topic(plain, "ros_discovery_info", Info), quality)
    writers = BuiltinDataReader(plain, BuiltinTopicDcpsPublication)
    people = BuiltinDataReader(plain, BuiltinTopicDcpsParticipant)
    infos, found = [], {}
    end = time.monotonic() + 30
    while time.monotonic() < end and not (infos and "rt/ns/joints" in found):
        infos += reader.take(10)
        found.update({w.topic_name: w for w in writers.read(200) if w.qos is not None})
        time.sleep(0.02)
    writer = found["rt/ns/joints"]
    assert writer.type_name == "sensor_msgs::msg::dds_::JointState_"
    assert writer.qos[Policy.Userdata].data == (
        b"typehash=RIHS01_a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e;"
    )
    told = infos[-1].node_entities_info_seq[0]
    assert (told.node_namespace, told.node_name) == ("/ns", "wire")
    assert pub._gid in [bytes(g.data) for g in told.writer_gid_seq]
    enclaves = [p.qos[Policy.Userdata].data for p in people.read(20) if Policy.Userdata in p.qos]
    assert b"enclave=/;" in enclaves


def test_requests_bear_a_sixteen_byte_header(make_node, spin, domain):
    """A request written by hand, with client id and number, is answered with the same header."""
    pytest.importorskip("rclpy_cyclone.dds", reason="writes the request with the stand-in's DDS")
    node = make_node()
    node.create_service(
        SetBool, "s", lambda q, r: (setattr(r, "success", q.data), setattr(r, "message", "m"), r)[2]
    )
    from rclpy_cyclone.dds import participant, qos

    plain = participant.Participant(domain)
    try:
        writer = plain.writer("rq/sRequest", "std_srvs/srv/SetBool_Request", qos.Policies())
        reader = plain.reader("rr/sReply", "std_srvs/srv/SetBool_Response", qos.Policies(), False)
        assert spin(lambda: participant.matched_readers(writer) == 1, node)
        head = struct.pack("<Qq", 0x1122334455667788, 42)
        participant.write(writer, b"\0\1\0\0" + head + b"\1")
        got = []
        assert spin(lambda: bool(got.extend(participant.take(reader)) or got), node)
        assert got[0][0][4:20] == head
        assert got[0][0][20:21] == b"\1" and got[0][0][24:30] == b"\2\0\0\0m\0"
    finally:
        plain.close()


def test_services_may_call_services_in_a_multithreaded_executor(make_node):
    """A service's callback can wait for another service if their groups let it."""
    import threading

    node = make_node()
    group = ReentrantCallbackGroup()
    node.create_service(
        SetBool, "inner", lambda q, r: (setattr(r, "success", True), r)[1], callback_group=group
    )
    inner = node.create_client(SetBool, "inner", callback_group=group)

    def outer(request, response):
        response.success = inner.call(SetBool.Request(), timeout_sec=30.0).success
        return response

    node.create_service(Trigger, "outer", outer)
    executor = MultiThreadedExecutor(3, context=node.context)
    executor.add_node(node)
    thread = threading.Thread(target=executor.spin, daemon=True)
    thread.start()
    caller = make_node("caller", context=node.context)
    client = caller.create_client(Trigger, "outer")
    assert client.wait_for_service(30.0)
    other = SingleThreadedExecutor(context=node.context)
    other.add_node(caller)
    future = client.call_async(Trigger.Request())
    other.spin_until_future_complete(future, timeout_sec=30.0)
    assert future.result().success
    executor.shutdown()
    thread.join(30.0)
    assert not thread.is_alive()


def test_wait_for_message(make_node):
    """A message that comes is returned, and none after the time is over."""
    import threading

    node = make_node()
    pub = node.create_publisher(String, "t", 10)
    assert wait_for_message(String, node, "t", time_to_wait=0.05) == (False, None)
    over = threading.Event()

    def publish():
        while not over.wait(0.1):  # whenever the subscription is there
            pub.publish(String(data="x"))

    thread = threading.Thread(target=publish)
    thread.start()
    try:
        assert wait_for_message(String, node, "t", time_to_wait=30) == (True, String(data="x"))
    finally:
        over.set()
        thread.join()


def test_coroutine_callbacks(make_node, spin):
    """A coroutine callback can await a service's response in a single-threaded executor."""
    node = make_node()
    group = ReentrantCallbackGroup()
    node.create_service(
        SetBool, "s", lambda q, r: (setattr(r, "success", True), r)[1], callback_group=group
    )
    client = node.create_client(SetBool, "s", callback_group=group)
    done = []

    async def callback(message):
        done.append((await client.call_async(SetBool.Request())).success)

    node.create_subscription(String, "t", callback, 10, callback_group=group)
    pub = node.create_publisher(String, "t", 10)
    assert client.wait_for_service(30.0)
    pub.publish(String())
    assert spin(lambda: done == [True], node)
