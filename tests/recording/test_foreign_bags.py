"""Bags of other machines: any message by field path, sqlite3, other clocks, gaps and disorder."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest
from foreign_bags import CONTROLLER_STATE, STATE_TYPE, as_sqlite, controller_state, foreign_mcap
from mcap.writer import Writer
from recording_samples import assert_same, made

from ecyl_ros.errors import InputError
from ecyl_ros.recording.bag import read_bag
from ecyl_ros.recording.load import load_recording
from ecyl_ros.recording.map_file import parse_map
from ecyl_ros.recording.mapped import contract_map, read_mapped
from ecyl_ros.recording.messages import definition, typestore
from ecyl_ros.recording.reader import read_recording
from ecyl_ros.recording.signals import Recording
from ecyl_ros.recording.writer import RecordingWriter, write_recording

STATE_MAP = {
    "joint": "cylinder",
    "signals": {
        "reference_position": {"topic": "/controller/state", "field": "reference.positions"},
        "rod_position": {"topic": "/joint_states", "field": "position"},
        "effort": {"topic": "/joint_states", "field": "effort", "unit": "N"},
        "rod_velocity": "/joint_states.velocity[1]",
    },
}
SECOND = 10**9


def test_fields_of_any_message_are_found_by_path_and_joint(tmp_path: Path) -> None:
    """A controller's state of the bag's own type, joints by name and arrays by index agree."""
    foreign_mcap(tmp_path / "a.mcap")
    recording = read_mapped(tmp_path / "a.mcap", parse_map(STATE_MAP, "m"))
    expected = 0.01 * np.sin(0.1 * np.arange(60))
    np.testing.assert_array_equal(recording.rod_position_m, expected)
    np.testing.assert_array_equal(recording.reference_position_m, expected)
    np.testing.assert_array_equal(recording.rod_force_n, 10.0 * expected)
    np.testing.assert_array_equal(recording.rod_velocity_m_per_s, expected)
    assert recording.rate_hz == pytest.approx(1000.0)
    assert recording.notes == ()


def test_a_sqlite3_bag_holds_the_same_recording(tmp_path: Path) -> None:
    """File and folder of sqlite3, ours and a foreign one, read as the MCAP they were made from."""
    foreign_mcap(tmp_path / "a.mcap")
    as_sqlite(tmp_path / "a.mcap", tmp_path / "a.db3")
    own = parse_map(STATE_MAP, "m")
    assert_same(read_mapped(tmp_path / "a.db3", own), read_mapped(tmp_path / "a.mcap", own))
    recording = made(80)
    write_recording(recording, tmp_path / "b.mcap")
    (tmp_path / "bag").mkdir()
    as_sqlite(tmp_path / "b.mcap", tmp_path / "bag" / "b_0.db3")
    assert_same(read_recording(tmp_path / "bag"), recording)
    for path in (tmp_path / "bag", tmp_path / "b.mcap"):
        topics = read_bag(path).topics
        assert [len(topic.data) for topic in topics.values()] == [80, 80, 80, 80]


def test_rosbags_own_sqlite3_writer_is_read(tmp_path: Path) -> None:
    """A folder bag that rosbags wrote in sqlite3 reads the same."""
    from rosbags.rosbag2 import StoragePlugin
    from rosbags.rosbag2 import Writer as BagWriter

    from ecyl_ros.recording.bag_contents import in_time_order

    recording = made(50)
    write_recording(recording, tmp_path / "a.mcap")
    source = read_bag(tmp_path / "a.mcap")
    with BagWriter(tmp_path / "bag", version=9, storage_plugin=StoragePlugin.SQLITE3) as writer:
        connections = {
            one.name: writer.add_connection(one.name, one.type, typestore=typestore())
            for one in source.topics.values()
        }
        for stamp, name, data in in_time_order(source):
            writer.write(connections[name], stamp, data)
    assert_same(load_recording(tmp_path / "bag"), recording)


@pytest.mark.parametrize("storage", ["MCAP", "SQLITE3"])
@pytest.mark.parametrize("mode", ["FILE", "MESSAGE"])
def test_bags_compressed_by_rosbag2_are_read(tmp_path: Path, storage: str, mode: str) -> None:
    """Files or messages in zstd frames, as rosbags writes them, hold the same recording."""
    from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin
    from rosbags.rosbag2 import Writer as BagWriter

    from ecyl_ros.recording.bag_contents import in_time_order

    recording = made(50)
    write_recording(recording, tmp_path / "a.mcap")
    source = read_bag(tmp_path / "a.mcap")
    writer = BagWriter(tmp_path / "bag", version=9, storage_plugin=StoragePlugin[storage])
    writer.set_compression(CompressionMode[mode], CompressionFormat.ZSTD)
    with writer:
        connections = {
            one.name: writer.add_connection(one.name, one.type, typestore=typestore())
            for one in source.topics.values()
        }
        for stamp, name, data in in_time_order(source):
            writer.write(connections[name], stamp, data)
    assert_same(read_recording(tmp_path / "bag"), recording)
    assert_same(read_mapped(tmp_path / "bag", contract_map()), recording)
    if mode == "FILE":
        (file,) = (tmp_path / "bag").glob("*.zstd")
        assert_same(load_recording(file), recording)
        file.write_bytes(file.read_bytes()[:-200])
        with pytest.raises(InputError, match=file.name):
            load_recording(file)


def test_every_number_equals_what_rosbags_decodes(tmp_path: Path) -> None:
    """All fields of a message of nested arrays, odd alignments and all widths, both byte orders."""
    from rosbags.typesys import get_types_from_msg

    from ecyl_ros.recording.columns import TopicDecoder, everything
    from ecyl_ros.recording.stream import BagStream

    text = (
        "bool a\nfloat64 b\nstring note\nint8[3] c\nuint16 d\nfloat32[] e\nPart[] parts\n"
        "Part[2] pair\nuint8 f\nint64 g\nstring[] names\nbyte h\nuint32 k\n"
        f"{'=' * 80}\nMSG: own/Part\nuint8 x\nfloat64 y\nint16[] z\n"
    )
    store = typestore()
    store.register(get_types_from_msg(text, "own/msg/Whole"))
    types = store.types
    random = np.random.default_rng(3)

    def part() -> object:
        values = random.integers(-99, 99, random.integers(0, 3)).astype(np.int16)
        return types["own/msg/Part"](x=int(random.integers(0, 99)), y=random.normal(), z=values)

    messages = [
        types["own/msg/Whole"](
            a=bool(random.integers(0, 2)),
            b=random.normal(),
            note="x" * int(random.integers(0, 3)),
            c=random.integers(-9, 9, 3).astype(np.int8),
            d=int(random.integers(0, 65536)),
            e=random.normal(size=2).astype(np.float32),
            parts=[part() for _ in range(2)],
            pair=[part(), part()],
            f=int(random.integers(0, 256)),
            g=int(random.integers(-(2**40), 2**40)),
            names=["p", "qq"],
            h=1,
            k=int(random.integers(0, 2**32)),
        )
        for _ in range(80)
    ]
    for little in (True, False):
        path = tmp_path / f"{little}.mcap"
        with path.open("wb") as file:
            writer = Writer(file)
            writer.start("ros2", "test")
            schema = writer.register_schema("own/msg/Whole", "ros2msg", text.encode())
            channel = writer.register_channel("/whole", "cdr", schema)
            for i, message in enumerate(messages):
                data = store.serialize_cdr(message, "own/msg/Whole", little_endian=little)
                writer.add_message(channel, i, bytes(data), i)
            writer.finish()
        (batch,) = list(BagStream(path))
        values = TopicDecoder(batch, everything).columns(batch).values
        for i, m in enumerate(messages):
            expected = {"a": m.a, "b": m.b, "d": m.d, "f": m.f, "g": m.g, "h": m.h, "k": m.k}
            expected |= {f"c[{j}]": m.c[j] for j in range(3)}
            expected |= {f"e[{j}]": m.e[j] for j in range(2)}
            for name, parts in (("parts", m.parts), ("pair", m.pair)):
                for j, one in enumerate(parts):
                    expected |= {f"{name}[{j}].x": one.x, f"{name}[{j}].y": one.y}
                    expected |= {f"{name}[{j}].z[{n}]": z for n, z in enumerate(one.z)}
            for key, value in expected.items():
                assert values[key][i] == value, (key, i)


def series(
    path: Path,
    joints: list[tuple[int, int, float]],
    commands: list[tuple[int, int, float]],
) -> Path:
    """A bag of (header stamp, log time, value): joint states of one rod, and commands to it."""
    types = typestore().types
    kind = "sensor_msgs/msg/JointState"
    entries = [("/joint_states", *one) for one in joints] + [("/command", *one) for one in commands]
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start("ros2", "test")
        schema = writer.register_schema(kind, "ros2msg", definition(kind).encode())
        channels = {
            name: writer.register_channel(name, "cdr", schema)
            for name in ("/joint_states", "/command")
        }
        for name, stamp, log, value in sorted(entries, key=lambda one: one[2]):
            message = types[kind](
                header=types["std_msgs/msg/Header"](
                    stamp=types["builtin_interfaces/msg/Time"](
                        sec=stamp // SECOND, nanosec=stamp % SECOND
                    ),
                    frame_id="",
                ),
                name=["rod"],
                position=np.array([value]),
                velocity=np.zeros(0),
                effort=np.zeros(0),
            )
            data = bytes(typestore().serialize_cdr(message, kind))
            writer.add_message(channels[name], log, data, log)
        writer.finish()
    return path


TWO = {
    "joint": "rod",
    "signals": {
        "reference_position": "/command.position",
        "rod_position": "/joint_states.position",
    },
}


def wave(seconds: np.ndarray) -> np.ndarray:
    """Where the rod is at an instant, m."""
    return 0.01 * np.sin(2.0 * np.pi * 0.8 * seconds)


def read_two(path: Path, **more: object) -> Recording:
    """The two topics of `series`."""
    return read_mapped(path, parse_map({**TWO, **more}, "m"))


def test_clocks_that_differ_and_drift_are_put_right(tmp_path: Path) -> None:
    """A command clock 2.5 s ahead that gains 80 ppm is found to 1 % and corrected to 2 ms."""
    random = np.random.default_rng(1)
    true = np.arange(30_000) * 1e-3 + 100.0
    delays = 2e-4 + random.exponential(5e-4, (2, true.size))
    other = (true - 100.0) * (1.0 + 80e-6) + 102.5
    joints = [
        (round(t * 1e9), round((t + d) * 1e9), float(wave(t)))
        for t, d in zip(true, delays[0], strict=True)
    ]
    commands = [
        (round(o * 1e9), round((t + d) * 1e9), float(wave(t)))
        for t, o, d in zip(true, other, delays[1], strict=True)
    ]
    recording = read_two(series(tmp_path / "a.mcap", joints, commands))
    (note,) = [note for note in recording.notes if "its clock" in note]
    assert "/command: its clock is 2.5" in note and "ahead of that of /joint_states" in note
    ppm = float(note.split("gains ")[1].split(" ppm")[0])
    assert ppm == pytest.approx(80.0, rel=0.01)
    apart = recording.reference_position_m - wave(recording.stamp_ns / 1e9)
    speed = 0.01 * 2.0 * np.pi * 0.8
    assert np.nanmax(np.abs(apart)) < 2e-3 * speed
    unmoved = read_two(tmp_path / "a.mcap", stamp="bag")
    assert not any("its clock" in note for note in unmoved.notes)


def test_the_same_clock_is_left_alone(tmp_path: Path) -> None:
    """Topics whose transport differs by some ms keep their stamps, to the ns."""
    stamps = SECOND + np.arange(3000) * 1_000_000
    value = wave(stamps / 1e9)
    joints = [(int(s), int(s) + 200_000, float(v)) for s, v in zip(stamps, value, strict=True)]
    commands = [(int(s), int(s) + 6_000_000, float(v)) for s, v in zip(stamps, value, strict=True)]
    recording = read_two(series(tmp_path / "a.mcap", joints, commands))
    np.testing.assert_array_equal(recording.stamp_ns, stamps)
    np.testing.assert_array_equal(recording.reference_position_m, recording.rod_position_m)
    assert recording.notes == ()


def test_disorder_repeats_and_losses_are_handled_and_told(tmp_path: Path) -> None:
    """Swapped, doubled and lost samples give the truth at what is left, and a note each."""
    stamps = (SECOND + np.arange(4000) * 1_000_000).tolist()
    lost = set(range(1000, 1060)) | {2000, 2500}
    joints = [(s, s, float(wave(np.array(s / 1e9)))) for i, s in enumerate(stamps) if i not in lost]
    joints[100], joints[101] = (
        (*joints[101][:1], *joints[100][1:2], joints[101][2]),
        (*joints[100][:1], *joints[101][1:2], joints[100][2]),
    )
    joints.insert(301, (joints[300][0], joints[300][1] + 10, 9.0))
    commands = [(s, s, float(wave(np.array(s / 1e9)))) for s in stamps]
    recording = read_two(series(tmp_path / "a.mcap", joints, commands))
    np.testing.assert_allclose(
        recording.rod_position_m, wave(recording.stamp_ns / 1e9), rtol=0, atol=1e-12
    )
    assert len(recording) == 4000 - len(lost)
    said = "\n".join(recording.notes)
    assert "/joint_states: 1 samples out of order" in said
    assert "1 stamps repeated, 1 of them with other values" in said
    assert "62 samples lost, in 3 places" in said


def test_uneven_stamps_are_resampled_and_gaps_stay(tmp_path: Path) -> None:
    """Stamps jittered by 20 % give the sine on an even grid to 1e-7 m, with a hole for the gap."""
    random = np.random.default_rng(5)
    true = 1.0 + np.arange(6000) * 1e-3 + random.uniform(-2e-4, 2e-4, 6000)
    true = true[(true < 3.0) | (true > 3.4)]
    joints = [(round(t * 1e9), round(t * 1e9), float(wave(t))) for t in true]
    slow = np.arange(1.0, 7.0, 0.01)
    commands = [(round(t * 1e9), round(t * 1e9), float(wave(t))) for t in slow]
    recording = read_two(series(tmp_path / "a.mcap", joints, commands))
    steps = np.diff(recording.stamp_ns) / 1e6
    assert np.median(steps) == pytest.approx(1.0, rel=1e-3)
    inside = steps < 100.0
    np.testing.assert_allclose(steps[inside], np.median(steps), atol=2e-6)
    assert steps.max() == pytest.approx(400.0, abs=3.0)
    seconds = recording.stamp_ns / 1e9
    assert np.abs(recording.rod_position_m - wave(seconds)).max() < 1e-7
    known = np.isfinite(recording.reference_position_m)
    assert known.mean() > 0.99
    assert np.abs(recording.reference_position_m - wave(seconds))[known].max() < 1e-6
    said = "\n".join(recording.notes)
    assert "stamps are uneven" in said and "1 gap of up to 0.4" in said


def test_arrival_times_are_put_back_to_their_beat(tmp_path: Path) -> None:
    """Samples taken each ms that arrive up to 2 ms late are read at the instants of the beat."""
    random = np.random.default_rng(7)
    true = 50.0 + np.arange(5000) * 1e-3
    arrival = np.maximum.accumulate(true + random.exponential(4e-4, true.size).clip(0.0, 2e-3))
    arrival += np.arange(5000) * 1e-9
    joints = [(0, round(a * 1e9), float(wave(t))) for t, a in zip(true, arrival, strict=True)]
    recording = read_two(series(tmp_path / "a.mcap", joints, joints))
    assert any("all header stamps are 0" in note for note in recording.notes)
    assert any("taken as sampled evenly" in note for note in recording.notes)
    left = recording.rod_position_m - wave(recording.stamp_ns / 1e9)
    rough = np.interp(arrival, true, wave(true)) - wave(true)
    assert np.abs(left).max() < 0.1 * np.abs(rough).max()


def test_a_clock_that_was_set_keeps_the_longest_run(tmp_path: Path) -> None:
    """Stamps that jump back by an hour after 1 s of 4 leave the 3 s behind the jump."""
    log = (5000 * SECOND + np.arange(4000) * 1_000_000).tolist()
    joints = [(s if i < 1000 else s - 3600 * SECOND, s, float(i)) for i, s in enumerate(log)]
    single = {"joint": "rod", "signals": {"rod_position": "/joint_states.position"}}
    series(tmp_path / "a.mcap", joints, [])
    recording = read_mapped(tmp_path / "a.mcap", parse_map(single, "m"))
    np.testing.assert_array_equal(recording.rod_position_m, np.arange(1000.0, 4000.0))
    assert any("clock was set 1 times" in note for note in recording.notes)


def test_our_own_topics_in_disorder_are_read_all_the_same(tmp_path: Path) -> None:
    """Without a map a recording of ours whose samples are doubled and swapped is put in order."""
    recording = made(200)
    write_recording(recording, tmp_path / "a.mcap")
    bag = read_bag(tmp_path / "a.mcap")
    with RecordingWriter(tmp_path / "b.mcap") as writer:
        for topic in bag.topics.values():
            order = [*range(50), 51, 50, 51, *range(52, 200)]
            for i in order:
                writer.write(topic.name, topic.data[i], topic.log_time_ns[i])
    with pytest.raises(InputError):
        read_recording(tmp_path / "b.mcap")
    back = load_recording(tmp_path / "b.mcap")
    assert_same(back, recording)
    assert "sorted and resampled" in back.notes[0]
    assert_same(read_mapped(tmp_path / "a.mcap", contract_map()), recording)


@pytest.mark.parametrize(
    ("entry", "said"),
    [
        ("/joint_stats.position", "no topic /joint_stats; did you mean /joint_states?"),
        ("/joint_states.position[7]", "position holds 2 values, expected an index below that"),
        ("/joint_states.positon", "no number at positon; there are"),
        ("/joint_states.position", "expected position[0] or a joint"),
        ("position", "no topic; expected topic, or a field such as /joint_states.position"),
        ({"field": "/joint_states.position", "joint": "boom"}, "no boom among the names"),
        ({"field": "/commands.data[0]", "stamp": "header"}, "have no header; expected stamp: bag"),
        ("/joint_states.position[cylinder].x", "no number at position[cylinder].x"),
        ("/joint_states.position[[", "is no path"),
    ],
)
def test_entries_that_fit_nothing_are_named(tmp_path: Path, entry: object, said: str) -> None:
    """A topic, field, joint or index that is not there is refused in one line that says what is."""
    foreign_mcap(tmp_path / "a.mcap", 5)
    with pytest.raises(InputError) as raised:
        read_mapped(tmp_path / "a.mcap", parse_map({"signals": {"rod_position": entry}}, "m"))
    assert said in str(raised.value) and "\n" not in str(raised.value)


def test_the_hand_written_state_is_what_rosbags_writes() -> None:
    """The bytes of the controller's state in these tests are those of rosbags' serialiser."""
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    store = get_typestore(Stores.ROS2_JAZZY)
    store.register(
        {
            name: fields
            for name, fields in get_types_from_msg(CONTROLLER_STATE, STATE_TYPE).items()
            if name == STATE_TYPE
        }
    )
    message = store.deserialize_cdr(controller_state(1_500_000_000, 0.25, 0.5), STATE_TYPE)
    assert message.joint_names == ["base", "cylinder"]
    assert message.reference.positions.tolist() == [-1.0, 0.25]
    assert message.feedback.positions.tolist() == [-1.0, 0.5]
    assert (message.header.stamp.sec, message.header.stamp.nanosec) == (1, 500_000_000)
    assert struct.calcsize("<d") == 8


def test_a_simulation_that_begins_at_zero_keeps_its_first_sample(tmp_path: Path) -> None:
    """A first stamp of 0 is a time like others, and nothing is noted."""
    joints = [(i * 1_000_000, i * 1_000_000, float(i)) for i in range(100)]
    recording = read_two(series(tmp_path / "a.mcap", joints, joints))
    assert recording.rod_position_m.tolist() == [float(i) for i in range(100)]
    assert recording.notes == ()


def test_single_samples_make_a_recording(tmp_path: Path) -> None:
    """A bag of one message per topic has no rate, and is read all the same."""
    series(tmp_path / "a.mcap", [(SECOND, SECOND, 0.5)], [(SECOND, SECOND, 0.25)])
    recording = read_two(tmp_path / "a.mcap")
    assert recording.rod_position_m.tolist() == [0.5]
    assert recording.reference_position_m.tolist() == [0.25]
