import numpy as np
import pytest

from ecyl_ros.recording import Recording, renamed


def test_time_is_exact_for_wall_clock_stamps():
    """Time since the first stamp is exact where seconds since 1970 resolve only 0.2 us."""
    start = 1_700_000_000_123_456_789
    recording = Recording(stamp_ns=np.array([start, start + 1, start + 10**9 + 7]))
    assert recording.time_s.tolist() == [0.0, 1e-9, (10**9 + 7) / 1e9]
    assert recording.duration_s == (10**9 + 7) / 1e9


def test_signals_not_given_are_nan_and_not_there():
    """A signal that nobody gave is NaN of full length, and `has` says no."""
    recording = Recording(stamp_ns=np.arange(3), rod_position_m=np.array([1.0, np.nan, 2.0]))
    assert np.isnan(recording.current_q_a).all() and recording.current_q_a.shape == (3,)
    assert not recording.has("current_q_a")
    assert recording.has("rod_position_m")
    with pytest.raises(KeyError):
        recording.has("rod_positon_m")


def test_arrays_are_copies_and_read_only():
    """Neither the caller's array nor the recording's can change the other."""
    values = np.zeros(2)
    recording = Recording(stamp_ns=np.arange(2), rod_position_m=values)
    values[0] = 5.0
    assert recording.rod_position_m[0] == 0.0
    with pytest.raises(ValueError, match="read-only"):
        recording.rod_position_m[0] = 1.0


@pytest.mark.parametrize(
    "stamps, values",
    [([0, 1, 1], None), ([0, 2, 1], None), ([0.0, 1.0, 2.0], None), ([0, 1, 2], [1.0, 2.0])],
)
def test_unusable_arrays_are_refused(stamps, values):
    """Stamps that repeat, go back or are floats, and lengths that differ, are errors."""
    signals = {} if values is None else {"rod_position_m": np.array(values)}
    with pytest.raises(ValueError):
        Recording(stamp_ns=np.array(stamps), **signals)


def test_slice_keeps_stamps_and_takes_the_start_not_the_end():
    """slice(a, b) holds a <= t < b and does not renumber its stamps."""
    recording = Recording(stamp_ns=np.arange(10) * 100_000_000 + 5)
    part = recording.slice(0.2, 0.5)
    assert part.stamp_ns.tolist() == [200_000_005, 300_000_005, 400_000_005]
    assert len(recording.slice(5.0)) == 0


def test_rate_is_the_median_and_survives_a_gap():
    """One long gap does not change the rate; one sample has none."""
    recording = Recording(stamp_ns=np.array([0, 1, 2, 3, 900]) * 1_000_000)
    assert recording.rate_hz == 1000.0
    assert np.isnan(Recording(stamp_ns=np.array([1])).rate_hz)


def test_topics_are_renamed_by_key():
    """Topic names change by key, the rest of the table stays; a wrong key is an error."""
    topics = renamed({"reference": "/axis/target"})
    assert [topic.name for topic in topics][:2] == ["/axis/target", "/ecyl/joint_states"]
    assert topics[0].signals["rod.position"] == "reference_position_m"
    with pytest.raises(KeyError):
        renamed({"refrence": "/axis/target"})
