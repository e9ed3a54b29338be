import struct

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer
from mcap_ros2.decoder import DecoderFactory
from mcap_ros2.writer import Writer as Ros2Writer
from recording_samples import assert_same, made

from ecyl_ros.errors import InputError
from ecyl_ros.recording import SIGNALS, TOPICS, renamed
from ecyl_ros.recording.bag import read_bag
from ecyl_ros.recording.bag_contents import in_time_order
from ecyl_ros.recording.reader import read_recording
from ecyl_ros.recording.writer import RecordingWriter, write_recording

MSGDEF = {
    "sensor_msgs/msg/JointState": (
        "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\n"
        "float64[] effort\n"
    ),
    "geometry_msgs/msg/Vector3Stamped": (
        "std_msgs/Header header\ngeometry_msgs/Vector3 vector\n"
        f"{'=' * 80}\nMSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n"
    ),
}
HEADER = (
    f"{'=' * 80}\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n"
    f"{'=' * 80}\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n"
)


def joint_state(ns, names, position, velocity=(), effort=()):
    """A JointState as a dictionary for mcap_ros2's writer."""
    return {
        "header": {"stamp": {"sec": ns // 10**9, "nanosec": ns % 10**9}, "frame_id": "f"},
        "name": list(names),
        "position": list(position),
        "velocity": list(velocity),
        "effort": list(effort),
    }


def foreign_file(path, entries, kind="sensor_msgs/msg/JointState"):
    """A file by mcap_ros2's writer from (topic, message) pairs of one type."""
    with path.open("wb") as file:
        writer = Ros2Writer(output=file)
        schema = writer.register_msgdef(kind, MSGDEF[kind] + HEADER)
        for i, (topic, message) in enumerate(entries):
            writer.write_message(topic, schema, message, log_time=i, publish_time=i)
        writer.finish()
    return path


@pytest.mark.parametrize("name", ["a.mcap", "bag"])
def test_what_was_written_is_read(tmp_path, name):
    """Arrays out and in are the same to the last bit, with nothing to note."""
    recording = made(3000)
    write_recording(recording, tmp_path / name)
    back = read_recording(tmp_path / name)
    assert_same(back, recording)
    assert back.notes == ()


def test_foreign_recordings_read_as_mcap_ros2_decodes_them(foreign):
    """Every value of another simulator's file equals what mcap_ros2 decodes, message by message."""
    path = foreign / "dev_03.mcap"
    recording = read_recording(path)
    rows = {topic.name: [] for topic in TOPICS}
    with path.open("rb") as file:
        for message in make_reader(
            file, decoder_factories=[DecoderFactory()]
        ).iter_decoded_messages():
            rows[message.channel.topic].append(message.decoded_message)
    joints = rows["/ecyl/joint_states"]
    np.testing.assert_array_equal(
        recording.stamp_ns, [m.header.stamp.sec * 10**9 + m.header.stamp.nanosec for m in joints]
    )
    for signal, values in {
        "rotor_position_rad": [m.position[0] for m in joints],
        "rod_position_m": [m.position[1] for m in joints],
        "rotor_velocity_rad_per_s": [m.velocity[0] for m in joints],
        "rotor_torque_nm": [m.effort[0] for m in joints],
        "rod_force_n": [m.effort[1] for m in joints],
        "reference_position_m": [m.position[0] for m in rows["/ecyl/reference"]],
        "current_q_a": [m.vector.y for m in rows["/ecyl/current"]],
        "voltage_d_v": [m.vector.x for m in rows["/ecyl/voltage"]],
    }.items():
        np.testing.assert_array_equal(recording.signal(signal), values, err_msg=signal)


def test_all_foreign_recordings_load(foreign):
    """Each holds 12 000 samples at 1 kHz, with nothing to note."""
    for path in sorted(foreign.glob("*.mcap")):
        recording = read_recording(path)
        assert (len(recording), recording.rate_hz, recording.notes) == (12000, 1000.0, ())


def test_bags_by_rosbags_are_read(tmp_path):
    """A folder bag that rosbags' own writer made, uncompressed, reads the same."""
    from rosbags.rosbag2 import StoragePlugin
    from rosbags.rosbag2 import Writer as BagWriter
    from rosbags.typesys import Stores, get_typestore

    recording = made(300)
    write_recording(recording, tmp_path / "a.mcap")
    source = read_bag(tmp_path / "a.mcap")
    store = get_typestore(Stores.ROS2_JAZZY)
    with BagWriter(tmp_path / "bag", version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        connections = {
            topic.name: writer.add_connection(topic.name, topic.type, typestore=store)
            for topic in source.topics.values()
        }
        for stamp, name, data in in_time_order(source):
            writer.write(connections[name], stamp, data)
    assert_same(read_recording(tmp_path / "bag"), recording)


@pytest.mark.parametrize("compression", list(CompressionType))
@pytest.mark.parametrize("chunked", [True, False])
def test_all_compressions_and_unchunked_files_are_read(tmp_path, compression, chunked):
    """zstd, lz4, none, and a file without chunks hold the same recording."""
    recording = made(100)
    write_recording(recording, tmp_path / "a.mcap")
    rewritten(tmp_path / "a.mcap", tmp_path / "b.mcap", compression=compression, chunked=chunked)
    assert_same(read_recording(tmp_path / "b.mcap"), recording)


def rewritten(source, target, *, compression=CompressionType.ZSTD, chunked=True, chunk_size=4000):
    """Copy messages into another kind of MCAP file by the mcap package."""
    with source.open("rb") as file, target.open("wb") as out:
        writer = Writer(out, compression=compression, use_chunking=chunked, chunk_size=chunk_size)
        writer.start("ros2", "test")
        ids = {}
        for schema, channel, message in make_reader(file).iter_messages(log_time_order=False):
            if channel.topic not in ids:
                own = writer.register_schema(schema.name, schema.encoding, schema.data)
                ids[channel.topic] = writer.register_channel(channel.topic, "cdr", own)
            writer.add_message(
                ids[channel.topic], message.log_time, message.data, message.publish_time
            )
        writer.finish()


@pytest.mark.parametrize("kind", ["zstd", "lz4", "unchunked"])
def test_a_file_cut_anywhere_keeps_what_is_whole(tmp_path, kind):
    """At every few bytes: a prefix of the recording, the longer the later the cut, and a note."""
    recording = made(120)
    write_recording(recording, tmp_path / "a.mcap")
    rewritten(
        tmp_path / "a.mcap",
        tmp_path / "b.mcap",
        compression=CompressionType.LZ4 if kind == "lz4" else CompressionType.ZSTD,
        chunked=kind != "unchunked",
    )
    data = (tmp_path / "b.mcap").read_bytes()
    cut = tmp_path / "cut.mcap"
    longest = 0
    for size in range(0, len(data), 61):
        cut.write_bytes(data[:size])
        try:
            part = read_recording(cut)
        except InputError as error:
            assert longest == 0, "a longer file gave less"
            assert "cut.mcap" in str(error) and "\n" not in str(error)
            continue
        assert len(part) >= longest
        longest = len(part)
        np.testing.assert_array_equal(part.stamp_ns, recording.stamp_ns[:longest])
        # Of the very first sample only the reference may be there yet.
        if longest > 1:
            expected = recording.rotor_position_rad[:longest]
            np.testing.assert_array_equal(part.rotor_position_rad, expected)
        assert any("cut off" in note for note in part.notes)
    assert longest == len(recording)


def test_a_tail_of_zeros_is_a_cut(tmp_path):
    """What a file system leaves after a power cut, zeros where data was due, ends the recording."""
    write_recording(made(3000), tmp_path / "a.mcap")
    data = (tmp_path / "a.mcap").read_bytes()
    half = len(data) // 2
    (tmp_path / "a.mcap").write_bytes(data[:half] + bytes(len(data) - half))
    part = read_recording(tmp_path / "a.mcap")
    assert 1000 < len(part) < 2000
    assert "cut off" in part.notes[0]


def test_damage_is_an_input_error_or_harmless(tmp_path):
    """400 random changes to a finished file: read the same, or refused in one line."""
    recording = made(60)
    write_recording(recording, tmp_path / "a.mcap")
    data = (tmp_path / "a.mcap").read_bytes()
    rng = np.random.default_rng(3)
    path = tmp_path / "b.mcap"
    refused = 0
    for _ in range(400):
        mutated = bytearray(data)
        for place in rng.integers(0, len(data), size=rng.integers(1, 4)):
            mutated[place] = rng.integers(0, 256)
        path.write_bytes(mutated)
        try:
            back = read_recording(path)
        except InputError as error:
            refused += 1
            assert "b.mcap" in str(error) and "\n" not in str(error)
        else:
            if not back.notes:
                assert_same(back, recording)
    assert refused > 100


def test_random_message_bytes_are_refused_by_index(tmp_path):
    """200 messages with changed bytes: refused, or another value or stamp, never a traceback."""
    write_recording(made(3), tmp_path / "a.mcap")
    good = read_bag(tmp_path / "a.mcap").topics["/ecyl/joint_states"].data
    rng = np.random.default_rng(4)
    for number in range(200):
        bad = bytearray(good[1])
        bad[int(rng.integers(0, len(bad)))] = int(rng.integers(0, 256))
        if number % 3 == 0:
            del bad[int(rng.integers(0, len(bad))) :]
        path = tmp_path / f"{number}.mcap"
        with RecordingWriter(path) as writer:
            for stamp, data in enumerate([good[0], bytes(bad), good[2]]):
                writer.write("/ecyl/joint_states", data, stamp)
        try:
            read_recording(path)
        except InputError as error:
            assert "/ecyl/joint_states" in str(error) and "\n" not in str(error)


@pytest.mark.parametrize(
    "content, named",
    [(b"", "empty"), (b"stamp_ns,rod\n", "no MCAP"), (b"\x89MCAP0\r\n", "cut off")],
)
def test_files_that_are_no_recording_are_refused(tmp_path, content, named):
    """Empty, text, and a bare magic are refused with the reason."""
    (tmp_path / "a.mcap").write_bytes(content)
    with pytest.raises(InputError, match=named):
        read_recording(tmp_path / "a.mcap")


def test_missing_paths_and_empty_folders_are_refused(tmp_path):
    """A path that is not there, and a folder without MCAP files, are named."""
    with pytest.raises(InputError, match="no such file"):
        read_recording(tmp_path / "none.mcap")
    with pytest.raises(InputError, match=r"expected \*.mcap"):
        read_recording(tmp_path)


@pytest.mark.parametrize(
    "text, named",
    [
        ("rosbag2_bagfile_information: 3", "relative_file_paths"),
        ("{", "relative_file_paths"),
        (
            "rosbag2_bagfile_information: {storage_identifier: tape, relative_file_paths: []}",
            "expected mcap or sqlite3",
        ),
        (
            "rosbag2_bagfile_information: {storage_identifier: mcap, relative_file_paths: [x]}",
            "x, which is missing",
        ),
        (
            "rosbag2_bagfile_information: {storage_identifier: mcap, relative_file_paths: [x],"
            " compression_format: rar}",
            "compression_format is 'rar', expected zstd",
        ),
    ],
)
def test_unusable_bag_metadata_is_refused_by_field(tmp_path, text, named):
    """metadata.yaml that is broken, of another storage, or names missing files."""
    (tmp_path / "metadata.yaml").write_text(text)
    with pytest.raises(InputError, match=named):
        read_recording(tmp_path)


def test_split_bags_are_joined_in_the_order_of_their_numbers(tmp_path):
    """Files _0, _2, _10 of a folder without metadata.yaml make one recording."""
    recording = made(300)
    for number, (start, stop) in {0: (0, 0.1), 2: (0.1, 0.2), 10: (0.2, 1)}.items():
        write_recording(recording.slice(start, stop), tmp_path / f"run_{number}.mcap")
    assert_same(read_recording(tmp_path), recording)


def test_another_type_or_name_is_named(tmp_path):
    """A topic of another type, and a file without any of the topics, say what was expected."""
    topics = renamed({"current": "/ecyl/joint_states", "joint_states": "/elsewhere"})
    write_recording(made(5), tmp_path / "a.mcap", topics=topics)
    with pytest.raises(InputError, match=r"/ecyl/joint_states: type is geometry_msgs.*expected"):
        read_recording(tmp_path / "a.mcap")
    with pytest.raises(InputError, match=r"no messages on any of /a.*its topics: .*/elsewhere"):
        read_recording(
            tmp_path / "a.mcap",
            topics=renamed(
                dict.fromkeys(("reference", "joint_states", "current", "voltage"), "/a")
            ),
        )


def test_other_topic_and_joint_names(tmp_path):
    """Names of the file's own are given by key and by joint."""
    messages = [
        ("/js", joint_state(i * 10**6, ["axis1", "motor"], [0.1 * i, 3.0 * i], [1.0, 2.0]))
        for i in range(5)
    ]
    foreign_file(tmp_path / "a.mcap", messages)
    recording = read_recording(
        tmp_path / "a.mcap",
        topics=renamed({"joint_states": "/js"}),
        joint_names={"rotor": "motor", "rod": "axis1"},
    )
    assert recording.rotor_position_rad.tolist() == [0.0, 3.0, 6.0, 9.0, 12.0]
    assert recording.rod_position_m.tolist() == [0.1 * i for i in range(5)]
    assert not recording.has("rotor_torque_nm")
    with pytest.raises(InputError, match=r"names are \[axis1, motor\], expected rotor or rod"):
        read_recording(tmp_path / "a.mcap", topics=renamed({"joint_states": "/js"}))


def test_joints_may_come_go_and_change_places(tmp_path):
    """Each message is read by its own joint names, whatever their order and number."""
    orders = [("rotor", "rod"), ("rod", "rotor"), ("rotor",), ("x", "rod", "rotor", "load")]
    value = {"rotor": 10.0, "rod": 20.0, "load": 30.0, "x": 40.0}
    messages = [
        ("/ecyl/joint_states", joint_state(i, names, [value[n] + i for n in names]))
        for i, names in enumerate(orders * 3)
    ]
    recording = read_recording(foreign_file(tmp_path / "a.mcap", messages))
    steps = np.arange(12.0)
    np.testing.assert_array_equal(recording.rotor_position_rad, 10.0 + steps)
    rod = np.where(steps % 4 == 2, np.nan, 20.0 + steps)
    np.testing.assert_array_equal(recording.rod_position_m, rod)
    load = np.where(steps % 4 == 3, 30.0 + steps, np.nan)
    np.testing.assert_array_equal(recording.load_position_rad, load)


@pytest.mark.parametrize(
    "stamps, named",
    [([0, 1, 1, 2], "message 2 repeats 1"), ([0, 5, 3, 8], "message 2 goes back to 3")],
)
def test_stamps_that_do_not_increase_are_refused(tmp_path, stamps, named):
    """A double stamp and a step back are refused with message and topic."""
    messages = [("/ecyl/joint_states", joint_state(ns, ["rod"], [0.0])) for ns in stamps]
    with pytest.raises(InputError, match=rf"/ecyl/joint_states: header\.stamp of {named}"):
        read_recording(foreign_file(tmp_path / "a.mcap", messages))


def test_topics_without_a_common_stamp_are_refused(tmp_path):
    """A reference half a step off every sample belongs to no sample."""
    messages = [("/ecyl/joint_states", joint_state(10 * i, ["rod"], [0.0])) for i in range(5)]
    messages += [("/ecyl/reference", joint_state(10 * i + 5, ["rod"], [0.0])) for i in range(5)]
    with pytest.raises(InputError, match="/ecyl/reference: none of its 5 stamps"):
        read_recording(foreign_file(tmp_path / "a.mcap", messages))


def test_lost_messages_are_nan_and_noted(tmp_path):
    """Samples that one topic lacks are NaN there; what has no place on the grid is counted."""
    messages = [("/ecyl/joint_states", joint_state(i, ["rotor", "rod"], [i, i])) for i in range(9)]
    messages += [("/ecyl/reference", joint_state(i, ["rod"], [i])) for i in (0, 4, 8, 20)]
    recording = read_recording(foreign_file(tmp_path / "a.mcap", messages))
    expected = np.full(9, np.nan)
    expected[[0, 4, 8]] = [0.0, 4.0, 8.0]
    np.testing.assert_array_equal(recording.reference_position_m, expected)
    notes = "\n".join(recording.notes)
    assert "/ecyl/reference: 6 of 9 samples missing" in notes
    assert "/ecyl/reference: 1 samples left out" in notes
    assert "/ecyl/voltage: no such topic" in notes


def test_without_joint_states_the_grid_is_what_is_there(tmp_path):
    """A recording of the reference alone gives its samples."""
    messages = [("/ecyl/reference", joint_state(i * 10**6, ["rod"], [i], [1])) for i in range(6)]
    recording = read_recording(foreign_file(tmp_path / "a.mcap", messages))
    assert recording.reference_position_m.tolist() == [0, 1, 2, 3, 4, 5]
    assert [name for name in SIGNALS if recording.has(name)] == [
        "reference_position_m",
        "reference_velocity_m_per_s",
    ]


def test_big_endian_messages_are_read(tmp_path):
    """CDR of the other byte order (header 0000) gives the same numbers."""
    with RecordingWriter(tmp_path / "a.mcap") as writer:
        for i in range(4):
            head = struct.pack(">4sii", b"\0\0\0\0", 7, 1000 * i) + struct.pack(">I4s", 4, b"dq0\0")
            data = head + struct.pack(">3d", 1.5 * i, -2.5 * i, 0.0)
            writer.write("/ecyl/current", data, i)
    recording = read_recording(tmp_path / "a.mcap")
    assert recording.current_q_a.tolist() == [0.0, -2.5, -5.0, -7.5]
    assert recording.stamp_ns[1] == 7_000_001_000
