import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from recording_samples import made

from ecyl_ros.recording.bag import read_bag
from ecyl_ros.recording.bag_contents import in_time_order
from ecyl_ros.recording.sequencer import SampleSequencer
from ecyl_ros.recording.writer import RecordingWriter, write_recording

TOPICS = ("/a", "/b", "/c")


def ran(arrivals, **options):
    """What comes out for (topic, stamp) arrivals, and the sequencer."""
    out = []
    sequencer = SampleSequencer(
        lambda topic, data, stamp: out.append((topic, stamp)), topics=TOPICS, **options
    )
    for topic, stamp in arrivals:
        sequencer.put(topic, b"", stamp)
    sequencer.finish()
    return out, sequencer


@st.composite
def interleavings(draw):
    """Messages of three topics, some lost, each topic in order, mixed in any way."""
    stamps = sorted(draw(st.sets(st.integers(0, 50), max_size=20)))
    queues = {topic: [stamp for stamp in stamps if draw(st.integers(0, 5))] for topic in TOPICS}
    kept = {topic: list(queue) for topic, queue in queues.items()}
    arrivals = []
    while any(queues.values()):
        topic = draw(st.sampled_from([topic for topic in TOPICS if queues[topic]]))
        arrivals.append((topic, queues[topic].pop(0)))
    return kept, arrivals


# How long the drawing takes says how busy the machine is.
@settings(suppress_health_check=[HealthCheck.too_slow])
@given(interleavings())
def test_any_interleaving_comes_out_in_canonical_order(case):
    """Whatever the mixture and whatever is lost: by stamp, then by topic, each message once."""
    kept, arrivals = case
    out, sequencer = ran(arrivals)
    expected = sorted(
        ((topic, stamp) for topic in TOPICS for stamp in kept[topic]),
        key=lambda entry: (entry[1], TOPICS.index(entry[0])),
    )
    assert out == expected
    whole = [stamp for stamp in {s for _, s in expected} if all(stamp in kept[t] for t in TOPICS)]
    assert sequencer.incomplete == len({s for _, s in expected}) - len(whole)
    assert sequencer.late == sequencer.duplicates == sequencer.pending == 0


def test_a_lost_message_holds_nothing_back():
    """A sample that lost a message is released once the topic has gone on to the next stamp."""
    out = []
    sequencer = SampleSequencer(lambda t, d, s: out.append((t, s)), topics=TOPICS)
    for topic, stamp in [("/a", 1), ("/b", 1), ("/a", 2), ("/b", 2), ("/c", 2)]:
        sequencer.put(topic, b"", stamp)
    assert out == [("/a", 1), ("/b", 1), ("/a", 2), ("/b", 2), ("/c", 2)]
    assert sequencer.incomplete == 1


def test_a_silent_topic_costs_bounded_memory():
    """With one topic silent, max_pending samples wait and the oldest go out in order."""
    out = []
    sequencer = SampleSequencer(lambda t, d, s: out.append((t, s)), topics=TOPICS, max_pending=10)
    for stamp in range(1000):
        sequencer.put("/b", b"", stamp)
        sequencer.put("/a", b"", stamp)
        assert sequencer.pending <= 10
    assert out[:4] == [("/a", 0), ("/b", 0), ("/a", 1), ("/b", 1)]
    assert [stamp for _, stamp in out] == sorted(stamp for _, stamp in out)


def test_late_and_double_messages_are_counted_and_no_topic_goes_back():
    """Behind its sample a message is passed on only where its topic's stamps go on increasing."""
    whole = [("/a", 1), ("/a", 1), ("/b", 1), ("/c", 1)]
    out, sequencer = ran([*whole, ("/a", 2), ("/b", 0), ("/c", 1)])
    assert out == [("/a", 1), ("/b", 1), ("/c", 1), ("/a", 2)]
    assert (sequencer.duplicates, sequencer.late) == (2, 1)
    out, sequencer = ran([("/a", 1), ("/a", 2), ("/b", 1), ("/b", 2)], max_pending=1)
    assert out == [("/a", 1), ("/b", 1), ("/a", 2), ("/b", 2)]
    assert (sequencer.duplicates, sequencer.late) == (0, 1)


def test_unannounced_topics_are_errors():
    """A topic that was not announced raises KeyError; so does an empty list of topics, its own."""
    with pytest.raises(KeyError):
        ran([("/d", 1)])
    with pytest.raises(ValueError):
        SampleSequencer(print, topics=())


def test_a_mixed_graph_gives_the_same_file_as_arrays(tmp_path):
    """Topic by topic in blocks, through the sequencer: byte for byte the file from arrays."""
    write_recording(made(3000), tmp_path / "arrays.mcap")
    messages = list(in_time_order(read_bag(tmp_path / "arrays.mcap")))
    with RecordingWriter(tmp_path / "graph.mcap") as writer:
        sequencer = SampleSequencer(writer.write)
        for block in range(0, len(messages), 400):
            for stamp, topic, data in sorted(messages[block : block + 400], key=lambda m: m[1]):
                sequencer.put(topic, data, stamp)
        sequencer.finish()
    assert (tmp_path / "graph.mcap").read_bytes() == (tmp_path / "arrays.mcap").read_bytes()
