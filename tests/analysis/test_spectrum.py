import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ecyl_ros.analysis.spectrum import amplitude_spectrum, dominant_lines
from ecyl_ros.errors import InputError

RATE = 1000.0
TIME = np.arange(10_000) / RATE


@given(
    frequency=st.floats(0.5, 480.0),
    amplitude=st.floats(1e-9, 1e3),
    phase=st.floats(0.0, 6.28),
)
def test_a_sine_is_found_wherever_it_lies_between_bins(frequency, amplitude, phase):
    """Frequency to a thousandth of a bin and amplitude to 0.1 %, on top of any constant."""
    values = amplitude * (np.sin(2 * np.pi * frequency * TIME + phase) + 17.0)
    (line, *others) = dominant_lines(amplitude_spectrum(values, RATE))
    assert abs(line.frequency_hz - frequency) < 1e-3 * 0.1
    assert line.amplitude == pytest.approx(amplitude, rel=1e-3)
    assert not others


def test_lines_come_strongest_first_with_their_amplitudes():
    """Three sines of a mixture, listed by height; what is under min_ratio is not."""
    parts = {3.45: 6.0, 1.0: 2.5, 50.3: 0.5, 90.0: 0.01}
    values = sum(a * np.sin(2 * np.pi * f * TIME + f) for f, a in parts.items())
    lines = dominant_lines(amplitude_spectrum(values, RATE))
    assert [round(line.frequency_hz, 2) for line in lines] == [3.45, 1.0, 50.3]
    assert [line.amplitude for line in lines] == pytest.approx([6.0, 2.5, 0.5], rel=5e-3)


def test_power_agrees_with_parseval():
    """For white noise, the bins' power is that of the signal under the window (Parseval)."""
    values = np.random.default_rng(0).normal(size=4096)
    spectrum = amplitude_spectrum(values, RATE)
    window = 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(4096) / 4096)
    mean = np.average(values, weights=window)
    power = np.sum(((values - mean) * window) ** 2)
    bins = (spectrum.amplitude * window.sum() / 2) ** 2
    bins[[0, -1]] *= 2
    assert 2 * bins.sum() / 4096 == pytest.approx(power, rel=1e-9)


def test_a_sweep_is_not_taken_for_taller_lines():
    """Peaks of a broad spectrum are not raised above the bins that show them."""
    values = np.sin(2 * np.pi * (2 * TIME + 0.5 * TIME**2))
    spectrum = amplitude_spectrum(values, RATE)
    lines = dominant_lines(spectrum)
    assert lines[0].amplitude <= 1.05 * spectrum.amplitude.max()


def test_too_short_for_the_line_asked_for():
    """A line of which less than three periods are there is refused, with the time it takes."""
    spectrum = amplitude_spectrum(np.sin(2 * np.pi * 0.2 * TIME), RATE)
    with pytest.raises(InputError, match="needs 15 s"):
        dominant_lines(spectrum, lowest_hz=0.2)
    assert dominant_lines(spectrum, lowest_hz=0.3) is not None


def test_a_trend_is_no_line():
    """What moves by less than three periods in the signal is not listed."""
    spectrum = amplitude_spectrum(np.sin(2 * np.pi * 0.1 * TIME), RATE)
    assert all(line.frequency_hz > 0.25 for line in dominant_lines(spectrum))


def test_unusable_signals_are_refused():
    """NaN and a handful of samples are refused; a constant has no line."""
    with pytest.raises(InputError, match="finite"):
        amplitude_spectrum(np.array([0.0, 1.0, np.nan, 2.0, 0.0]), RATE)
    with pytest.raises(InputError, match="4 samples"):
        amplitude_spectrum(np.zeros(3), RATE)
    assert dominant_lines(amplitude_spectrum(np.full(100, 3.0), RATE)) == ()


def test_the_line_asked_for_has_its_amplitude_beside_a_stronger_one():
    """1 Hz of 2 beside 3.45 Hz of 9: 2 to 0.5 %, also when 1 Hz is no bin."""
    from ecyl_ros.analysis.spectrum import line_at

    time = np.arange(9730) / RATE
    values = 2.0 * np.sin(2 * np.pi * time + 0.4) + 9.0 * np.sin(2 * np.pi * 3.45 * time) + 5.0
    assert line_at(values, RATE, 1.0).amplitude == pytest.approx(2.0, rel=5e-3)
    with pytest.raises(InputError, match="too short"):
        line_at(values[:2000], RATE, 1.0)
    with pytest.raises(InputError, match="cannot show"):
        line_at(values, RATE, 600.0)
