import signal
import subprocess
import sys

import numpy as np
import pytest
import yaml
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from recording_samples import made

from ecyl_ros.errors import InputError
from ecyl_ros.recording import TOPICS
from ecyl_ros.recording.bag import read_bag
from ecyl_ros.recording.mend import mend
from ecyl_ros.recording.reader import read_recording
from ecyl_ros.recording.writer import RecordingWriter, write_recording

NAMES = [topic.name for topic in TOPICS]


def test_other_readers_see_the_contract(tmp_path):
    """Read by mcap and mcap_ros2: profile, types, frames, joints, values, stamps, order."""
    recording = made(50)
    write_recording(recording, tmp_path / "a.mcap")
    with (tmp_path / "a.mcap").open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        assert reader.get_header().profile == "ros2"
        messages = list(reader.iter_decoded_messages(log_time_order=False))
    assert [channel.topic for _, channel, _, _ in messages] == NAMES * 50
    for i in range(50):
        reference, joints, current, voltage = (
            m.decoded_message for m in messages[4 * i : 4 * i + 4]
        )
        for (schema, channel, raw, _), topic in zip(
            messages[4 * i : 4 * i + 4], TOPICS, strict=True
        ):
            assert schema.name == topic.type and schema.encoding == "ros2msg"
            assert channel.message_encoding == "cdr"
            assert raw.log_time == raw.publish_time == recording.stamp_ns[i]
        for message in (reference, joints, current, voltage):
            stamp = message.header.stamp
            assert stamp.sec * 10**9 + stamp.nanosec == recording.stamp_ns[i]
        assert reference.header.frame_id == "rod" and list(reference.name) == ["rod"]
        assert reference.position[0] == recording.reference_position_m[i]
        assert reference.velocity[0] == recording.reference_velocity_m_per_s[i]
        assert len(reference.effort) == 0
        assert joints.header.frame_id == "base" and list(joints.name) == ["rotor", "rod", "load"]
        assert list(joints.position) == [
            recording.rotor_position_rad[i],
            recording.rod_position_m[i],
            recording.load_position_rad[i],
        ]
        assert list(joints.effort)[:2] == [recording.rotor_torque_nm[i], recording.rod_force_n[i]]
        assert np.isnan(joints.effort[2])
        assert current.header.frame_id == voltage.header.frame_id == "dq0"
        assert (current.vector.x, current.vector.y) == (
            recording.current_d_a[i],
            recording.current_q_a[i],
        )
        assert voltage.vector.y == recording.voltage_q_v[i] and voltage.vector.z == 0.0


def test_bytes_are_those_of_rosbags(tmp_path):
    """Messages from arrays are byte for byte what rosbags serialises, as nodes would publish."""
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_JAZZY)
    write_recording(made(3), tmp_path / "a.mcap")
    for topic in read_bag(tmp_path / "a.mcap").topics.values():
        for data in topic.data:
            message = store.deserialize_cdr(data, topic.type)
            assert bytes(store.serialize_cdr(message, topic.type)) == data


def test_identical_input_gives_identical_bytes(tmp_path):
    """Two writes compare equal; another sample does not."""
    write_recording(made(2000), tmp_path / "a.mcap")
    write_recording(made(2000), tmp_path / "b.mcap")
    write_recording(made(2000, seed=2), tmp_path / "c.mcap")
    first = (tmp_path / "a.mcap").read_bytes()
    assert first == (tmp_path / "b.mcap").read_bytes()
    assert first != (tmp_path / "c.mcap").read_bytes()


def test_topics_and_joints_that_nothing_measured_are_left_out(tmp_path):
    """No voltage measured: no voltage topic; no load measured: no joint of that name."""
    without = ("voltage_d_v", "voltage_q_v", "load_position_rad", "load_velocity_rad_per_s")
    write_recording(made(5, without=without), tmp_path / "a.mcap")
    bag = read_bag(tmp_path / "a.mcap")
    assert sorted(bag.topics) == sorted(NAMES[:3])
    assert b"load" not in bag.topics["/ecyl/joint_states"].data[0]


def test_folder_bag_is_read_by_rosbags(tmp_path):
    """A path without .mcap becomes a rosbag2 folder that rosbags opens, with types and hashes."""
    from rosbags.rosbag2 import Reader
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_JAZZY)
    recording = made(20)
    write_recording(recording, tmp_path / "deep" / "bag")
    with Reader(tmp_path / "deep" / "bag") as reader:
        assert reader.message_count == 80
        assert reader.start_time == recording.stamp_ns[0]
        for connection in reader.connections:
            assert connection.digest == store.hash_rihs01(connection.msgtype)
            assert connection.msgcount == 20
            assert connection.ext.offered_qos_profiles[0].reliability.name == "RELIABLE"
    about = yaml.safe_load((tmp_path / "deep" / "bag" / "metadata.yaml").read_text())
    about = about["rosbag2_bagfile_information"]
    assert about["relative_file_paths"] == ["bag_0.mcap"] and about["message_count"] == 80
    assert about["duration"]["nanoseconds"] == 19_000_000


def test_channels_carry_what_rosbag2_writes(tmp_path):
    """Channel metadata holds QoS profiles as YAML text and the type's RIHS01 hash."""
    write_recording(made(5), tmp_path / "a.mcap")
    with (tmp_path / "a.mcap").open("rb") as file:
        for channel in make_reader(file).get_summary().channels.values():
            (qos,) = yaml.safe_load(channel.metadata["offered_qos_profiles"])
            assert (qos["history"], qos["depth"], qos["reliability"]) == (
                "keep_last",
                10,
                "reliable",
            )
            assert channel.metadata["topic_type_hash"].startswith("RIHS01_")
            assert len(channel.metadata["topic_type_hash"]) == 7 + 64


def test_chunks_close_by_size(tmp_path):
    """All chunks but the last reach the size asked for by less than one message."""
    write_recording(made(4000), tmp_path / "a.mcap")
    with (tmp_path / "a.mcap").open("rb") as file:
        sizes = [c.uncompressed_size for c in make_reader(file).get_summary().chunk_indexes]
    assert len(sizes) > 4
    # The first chunk also holds schemas and channels.
    assert all(256 * 1024 <= size < 256 * 1024 + 200 for size in sizes[1:-1])
    assert sizes[-1] <= 256 * 1024 + 200


def test_existing_targets_stay(tmp_path):
    """A target that exists is refused and untouched, unless overwriting was asked for."""
    file, folder = tmp_path / "a.mcap", tmp_path / "bag"
    for path in (file, folder):
        write_recording(made(5), path)
        with pytest.raises(InputError, match="exists already"):
            write_recording(made(6), path)
        assert len(read_recording(path)) == 5
        write_recording(made(7), path, overwrite=True)
        assert len(read_recording(path)) == 7


def test_overwriting_never_removes_what_is_no_recording(tmp_path):
    """A folder with other files in it, or a file where a folder is meant, is left alone."""
    precious = tmp_path / "home"
    precious.mkdir()
    (precious / "thesis.tex").write_text("x")
    with pytest.raises(InputError, match=r"thesis\.tex"):
        write_recording(made(5), precious, overwrite=True)
    assert (precious / "thesis.tex").read_text() == "x"
    (tmp_path / "notes").write_text("y")
    with pytest.raises(InputError, match="no bag folder"):
        write_recording(made(5), tmp_path / "notes", overwrite=True)


def test_nothing_to_write_leaves_nothing_behind(tmp_path):
    """An empty recording, one without signals, and stamps before 1970 are refused, no file made."""
    from ecyl_ros.recording import Recording

    for recording in (
        made(0),
        Recording(stamp_ns=np.arange(3)),
        Recording(stamp_ns=np.arange(3) - 1, rod_position_m=np.zeros(3)),
        Recording(stamp_ns=np.arange(3) + 2**31 * 10**9, rod_position_m=np.zeros(3)),
    ):
        with pytest.raises(InputError):
            write_recording(recording, tmp_path / "sub" / "a.mcap")
    assert list(tmp_path.iterdir()) == []


def test_a_parent_that_is_a_file_is_an_input_error(tmp_path):
    """A path below a file is one clear line."""
    (tmp_path / "x").write_text("")
    with pytest.raises(InputError, match="cannot be created"):
        RecordingWriter(tmp_path / "x" / "a.mcap")


def test_unknown_topics_are_errors(tmp_path):
    """Writing to a topic that was not announced raises; the file is finished all the same."""
    with pytest.raises(KeyError), RecordingWriter(tmp_path / "a.mcap") as writer:
        writer.write("/other", b"", 0)
    assert read_bag(tmp_path / "a.mcap").notes == ()


KILLED = """
import os, signal, sys
from ecyl_ros.recording.writer import RecordingWriter
writer = RecordingWriter(sys.argv[1], chunk_bytes=4096)
for i in range(1000):
    writer.write("/ecyl/current", bytes(44), i)
print("ready", flush=True)
os.kill(os.getpid(), signal.SIGKILL)
"""


@pytest.mark.parametrize("name", ["a.mcap", "bag"])
def test_a_killed_writer_loses_only_its_open_chunk(tmp_path, name):
    """After SIGKILL all closed chunks can be read: 54 messages of 75 bytes are in the open one."""
    done = subprocess.run(
        [sys.executable, "-c", KILLED, str(tmp_path / name)],
        capture_output=True,
        text=True,
        cwd=tmp_path,  # the repository's root holds a folder with the package's name
    )
    assert done.returncode == -signal.SIGKILL and done.stdout == "ready\n"
    bag = read_bag(tmp_path / name)
    per_chunk = -(-4096 // 75)
    assert 1000 - per_chunk < bag.message_count <= 1000
    assert bag.topics["/ecyl/current"].log_time_ns == list(range(bag.message_count))
    assert len(bag.notes) == 1 and "was not closed" in bag.notes[0]
    # The format's own library opens the file too, by index where that is asked for.
    from mcap.reader import SeekingReader

    file = tmp_path / name if name.endswith(".mcap") else tmp_path / name / f"{name}_0.mcap"
    with file.open("rb") as stream:
        reader = SeekingReader(stream)
        assert reader.get_summary() is None  # there is no index, which is no error
        assert [m.log_time for _, _, m in reader.iter_messages()] == list(range(bag.message_count))


LIMITED = """
import resource, sys
from ecyl_ros.cli.main import InputError
from ecyl_ros.recording.reader import read_recording
from ecyl_ros.recording.writer import write_recording
recording = read_recording(sys.argv[1])
resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000))
try:
    write_recording(recording, sys.argv[2], overwrite=True)
except InputError as error:
    print(error)
"""


@pytest.mark.parametrize("name", ["old.mcap", "new.mcap", "bag"])
def test_a_disk_that_fills_up_leaves_no_half_recording(tmp_path, name):
    """Past 100 kB writing fails: one line with the file, nothing left, an old file untouched."""
    write_recording(made(5000), tmp_path / "source.mcap")
    write_recording(made(5), tmp_path / "old.mcap")
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    done = subprocess.run(
        [sys.executable, "-c", LIMITED, str(tmp_path / "source.mcap"), str(tmp_path / name)],
        capture_output=True,
        text=True,
        cwd=tmp_path,
    )
    assert f"{tmp_path / name}" in done.stdout
    assert "cannot be written: File too large" in done.stdout and done.stdout.count("\n") == 1
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_a_mended_recording_is_closed_and_holds_every_whole_message(tmp_path):
    """Cut anywhere, `mend` gives a closed file with the same bytes and times as can be read."""
    from mcap.reader import SeekingReader

    write_recording(made(5000), tmp_path / "whole.mcap")
    whole = (tmp_path / "whole.mcap").read_bytes()
    for share in (0.3, 0.8):
        (tmp_path / "cut.mcap").write_bytes(whole[: int(share * len(whole))])
        count, notes = mend(tmp_path / "cut.mcap", tmp_path / "mended.mcap")
        assert len(notes) == 1 and "cut off" in notes[0]
        cut, mended = read_bag(tmp_path / "cut.mcap"), read_bag(tmp_path / "mended.mcap")
        assert mended.notes == () and count == mended.message_count == cut.message_count > 0
        for name, topic in cut.topics.items():
            other = mended.topics[name]
            assert (other.data, other.log_time_ns) == (topic.data, topic.log_time_ns)
            assert (other.type, other.qos) == (topic.type, topic.qos)
        with (tmp_path / "mended.mcap").open("rb") as stream:
            summary = SeekingReader(stream).get_summary()
        assert summary is not None and summary.statistics.message_count == count


def test_what_is_no_recording_is_not_mended(tmp_path):
    """A text file is one clear line, and no output is left."""
    (tmp_path / "notes.mcap").write_text("no recording at all")
    with pytest.raises(InputError, match="is no MCAP file"):
        mend(tmp_path / "notes.mcap", tmp_path / "out.mcap")
    assert [path.name for path in tmp_path.iterdir()] == ["notes.mcap"]
