import numpy as np
import pytest

from ecyl_ros.analysis.running import RunningTracking
from ecyl_ros.errors import InputError

TIME = np.arange(10_000) / 1000.0
STAMPS = (np.arange(10_000) * 1_000_000 + 7).tolist()
REFERENCE = 2e-5 * np.sin(2 * np.pi * TIME)
POSITION = 2e-5 * np.sin(2 * np.pi * (TIME - 0.019))


def test_figures_are_those_of_the_window():
    """After ten seconds a window of four gives the last four seconds' error, lag and line."""
    running = RunningTracking(4.0)
    for stamp, reference, position in zip(
        STAMPS, REFERENCE.tolist(), POSITION.tolist(), strict=True
    ):
        running.update(stamp, reference, position)
    figures = running.figures()
    error = (REFERENCE - POSITION)[-4000:]
    assert (figures.samples, figures.duration_s) == (4000, 3.999)
    assert figures.error_rms_m == pytest.approx(np.sqrt(np.mean(error**2)), rel=1e-12)
    assert figures.error_std_m == pytest.approx(error.std(), rel=1e-12)
    assert figures.lag.lag_s == pytest.approx(0.019, abs=1e-6)
    assert figures.lines[0].frequency_hz == pytest.approx(1.0, abs=1e-3)


def test_before_there_is_enough_it_says_so():
    """No sample, and few: NaN or plain figures, never an exception."""
    running = RunningTracking()
    assert running.figures().samples == 0 and np.isnan(running.figures().error_rms_m)
    for i in range(10):
        running.update(i, 1.0, 0.5)
    figures = running.figures()
    assert figures.error_rms_m == 0.5
    assert figures.lag.reason == "not enough samples yet" and figures.lines == ()


def test_bad_samples_are_dropped_and_counted():
    """NaN, infinity and stamps that repeat or step back do not enter the window."""
    running = RunningTracking(1.0)
    running.update(10, 0.0, 0.0)
    for sample in ((11, float("nan"), 0.0), (11, 0.0, float("inf")), (10, 0.0, 9.0), (9, 0.0, 9.0)):
        running.update(*sample)
    assert running.dropped == 4
    assert running.figures().samples == 1


def test_a_restarted_clock_empties_the_window():
    """A jump back by more than the window restarts instead of dropping all that follows."""
    running = RunningTracking(1.0)
    running.update(5_000_000_000, 1.0, 0.0)
    running.update(0, 2.0, 0.0)
    assert (running.restarts, running.dropped) == (1, 0)
    assert running.figures().error_max_m == 2.0


def test_memory_is_bounded_whatever_the_rate():
    """max_samples holds even where the window would take more."""
    running = RunningTracking(1000.0, max_samples=100)
    for i in range(500):
        running.update(i, 0.0, float(i))
    assert running.figures().samples == 100
    assert running.figures().error_max_m == 499.0


def test_a_window_without_length_is_refused():
    """Zero, negative and infinite windows are refused."""
    for window in (0.0, -1.0, float("inf"), float("nan")):
        with pytest.raises(InputError, match="window"):
            RunningTracking(window)
