from itertools import islice

import pytest
from recording_samples import made

from ecyl_ros.errors import InputError
from ecyl_ros.recording.bag import read_bag
from ecyl_ros.recording.timeline import Timeline
from ecyl_ros.recording.writer import RecordingWriter

MS = 1_000_000


@pytest.fixture
def bag(tmp_path):
    """Two topics, stamps 0, 1, 2 and 5 ms after one second; the second topic only at 1 and 5."""
    with RecordingWriter(tmp_path / "a.mcap") as writer:
        for ms in (0, 1, 2, 5):
            writer.write("/ecyl/current", f"c{ms}".encode(), 10**9 + ms * MS)
            if ms in (1, 5):
                writer.write("/ecyl/reference", f"r{ms}".encode(), 10**9 + ms * MS)
    return read_bag(tmp_path / "a.mcap")


def played(bag, count=None, **options):
    """(due in ms, data) of the events, clock ticks as their bag time in ms."""
    return [
        (event.due_ns / MS, event.data.decode() if event.topic else (event.bag_ns - 10**9) / MS)
        for event in islice(Timeline(bag, **options), count)
    ]


def test_messages_are_due_as_they_were_logged(bag):
    """At rate 1 the gaps between messages are the bag's, equal times in file order."""
    assert played(bag) == [(0, "c0"), (1, "c1"), (1, "r1"), (2, "c2"), (5, "c5"), (5, "r5")]


def test_rate_offset_and_topics(bag):
    """Twice the speed halves the gaps; an offset cuts the start, in bag time; topics filter."""
    options = {"rate": 2.0, "start_offset_s": 0.001, "topics": ["/ecyl/current"]}
    assert played(bag, **options) == [(0, "c1"), (0.5, "c2"), (2, "c5")]


def test_clock_ticks_come_at_their_own_rate_before_equal_messages(bag):
    """500 Hz of playback at half speed: a tick each 2 ms, which is 1 ms of the bag's time."""
    events = played(bag, rate=0.5, clock_hz=500.0, topics=["/ecyl/reference"])
    ticks = [(due, value) for due, value in events if not isinstance(value, str)]
    assert ticks == [(0, 1), (2, 2), (4, 3), (6, 4), (8, 5)]
    assert events[0] == (0, 1) and events[-1] == (8, "r5")


def test_a_loop_goes_on_after_one_mean_interval(bag):
    """Round two begins a mean interval of 5/3 ms after the last message of round one."""
    events = played(bag, 10, loop=True, topics=["/ecyl/current"])
    assert [data for _, data in events] == ["c0", "c1", "c2", "c5"] * 2 + ["c0", "c1"]
    assert [due for due, _ in events[4:8]] == pytest.approx([20 / 3 + d for d in (0, 1, 2, 5)])


def test_no_error_adds_up_over_a_million_messages():
    """At a rate without a finite binary fraction the last message of 1e6 is due to the ns."""
    from ecyl_ros.recording.bag_contents import Bag, TopicMessages

    count = 1_000_000
    topic = TopicMessages("/a", "x/msg/Y", "cdr")
    topic.log_time_ns = [1_700_000_000 * 10**9 + i * MS for i in range(count)]
    topic.order = list(range(count))
    topic.data = [b""] * count
    timeline = Timeline(Bag("a", {"/a": topic}), rate=3.0)
    assert timeline.duration_ns == round((count - 1) * MS / 3)


def test_unplayable_options_are_named(bag):
    """Each option out of range, an unknown topic and an offset past the end: one line, named."""
    for options, named in (
        ({"rate": 0.0}, "--rate"),
        ({"rate": float("nan")}, "--rate"),
        ({"start_offset_s": -1.0}, "--start-offset"),
        ({"start_offset_s": 0.006}, "--start-offset is 0.006 s, the bag ends at 0.005"),
        ({"clock_hz": -1.0}, "--clock"),
        ({"topics": ["/nope"]}, "holds no topic /nope; its topics: /ecyl/current"),
        ({"topics": ["/ecyl/voltage"]}, "no message to play"),
    ):
        with pytest.raises(InputError, match=named):
            Timeline(bag, **options)


def test_the_verb_refuses_before_it_needs_ros(tmp_path, capsys):
    """Bad flags of `ecyl replay`: exit 2 and one line, on machines without rclpy too."""
    from ecyl_ros.cli.main import main
    from ecyl_ros.recording.writer import write_recording

    path = str(tmp_path / "a.mcap")
    write_recording(made(5), path)
    for arguments, named in (
        ([str(tmp_path / "b.mcap")], "no such file"),
        ([path, "--rate", "0"], "--rate"),
        ([path, "--delay", "-1"], "--delay"),
        ([path, "--remap", "/a"], "--remap is /a"),
        ([path, "--remap", "/a:=/b"], "holds no topic /a"),
        ([path, "--topics", "/a"], "holds no topic /a"),
    ):
        assert main(["replay", *arguments]) == 2
        err = capsys.readouterr().err
        assert named in err and err.count("\n") == 1
