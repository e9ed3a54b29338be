import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ecyl_ros.analysis.lag import lag_and_gain
from ecyl_ros.errors import InputError

RATE = 1000.0
TIME = np.arange(10_000) / RATE


def chirp(time):
    """0.3 to 4 Hz within ten seconds."""
    return 1e-3 * np.sin(2 * np.pi * (0.3 * time + 0.185 * time**2))


@settings(max_examples=40, deadline=None)
@given(
    frequency=st.floats(0.5, 5.0),
    constant=st.floats(1e-4, 0.1),
    scale=st.floats(1e-6, 1.0),
)
def test_a_first_order_lag_on_a_sine_has_its_closed_form(frequency, constant, scale):
    """Lag atan(w T) / w and gain 1 / sqrt(1 + (w T)^2), to a nanosecond and 1e-7."""
    omega = 2 * np.pi * frequency
    phase, size = np.arctan(omega * constant), np.hypot(1.0, omega * constant)
    lag = lag_and_gain(
        scale * np.sin(omega * TIME), scale / size * np.sin(omega * TIME - phase), RATE
    )
    assert lag.lag_s == pytest.approx(phase / omega, abs=1e-9 + 1e-7 * phase / omega)
    assert lag.gain == pytest.approx(1.0 / size, rel=1e-7)
    assert lag.residual_rms < 1e-6 * scale


@settings(max_examples=40, deadline=None)
@given(delay=st.floats(0.0, 0.95), gain=st.floats(0.1, 10.0), offset=st.floats(-1.0, 1.0))
def test_a_pure_delay_is_found_between_samples(delay, gain, offset):
    """A delayed chirp gives its delay to 10 ns of a 1 ms step, its gain and its offset."""
    lag = lag_and_gain(chirp(TIME), gain * chirp(TIME - delay) + offset, RATE)
    assert lag.lag_s == pytest.approx(delay, abs=1e-8)
    assert lag.gain == pytest.approx(gain, rel=1e-6)
    assert lag.offset == pytest.approx(offset, abs=1e-9)


def test_an_integrated_first_order_lag_is_read_the_same():
    """The response of a first-order lag solved by scipy's lsim gives the closed form too."""
    from scipy.signal import lsim

    omega, constant = 2 * np.pi, 0.055
    reference = 2e-5 * np.sin(omega * TIME)
    _, response, _ = lsim(([1.0], [constant, 1.0]), reference, TIME)
    settled = TIME >= 2.0
    lag = lag_and_gain(reference[settled], response[settled], RATE)
    assert lag.lag_s == pytest.approx(np.arctan(omega * constant) / omega, abs=1e-6)
    assert lag.gain == pytest.approx(1 / np.hypot(1, omega * constant), rel=1e-5)


def test_a_periodic_reference_gives_the_smallest_causal_lag():
    """On a 1 Hz sine 0.6 s behind is not read as 0.4 s ahead, nor 0.02 s as a period and 0.02 s."""
    for true in (0.02, 0.3, 0.6, 0.85):
        response = np.sin(2 * np.pi * (TIME - true))
        assert lag_and_gain(np.sin(2 * np.pi * TIME), response, RATE).lag_s == pytest.approx(true)


def test_a_response_slightly_ahead_is_negative():
    """Feedforward can lead by a little; that is a negative lag, not a period less it."""
    lag = lag_and_gain(np.sin(2 * np.pi * TIME), np.sin(2 * np.pi * (TIME + 0.0031)), RATE)
    assert lag.lag_s == pytest.approx(-0.0031, abs=1e-8)


def test_noise_spreads_the_lag_as_theory_says():
    """With noise sigma on n samples of A sin(w t), the lag is off by sigma / (A w sqrt(n / 2))."""
    rng = np.random.default_rng(5)
    sigma, n = 0.1, TIME.size
    reference = np.sin(2 * np.pi * TIME)
    errors = [
        lag_and_gain(
            reference, np.sin(2 * np.pi * (TIME - 0.05)) + sigma * rng.normal(size=n), RATE
        ).lag_s
        - 0.05
        for _ in range(20)
    ]
    bound = sigma / (2 * np.pi * np.sqrt(n / 2))
    assert np.abs(np.mean(errors)) < bound
    assert 0.5 * bound < np.std(errors) < 1.7 * bound


def test_far_from_zero_the_lag_is_the_same():
    """20 um of motion at a position of 0.3 m: the large constant does not hide the lag."""
    reference = 0.3 + 2e-5 * np.sin(2 * np.pi * TIME)
    response = 0.3 + 1.9e-5 * np.sin(2 * np.pi * (TIME - 0.019))
    lag = lag_and_gain(reference, response, RATE)
    assert lag.lag_s == pytest.approx(0.019, abs=1e-7)
    assert lag.gain == pytest.approx(0.95, rel=1e-5)


def test_what_never_moves_has_no_lag_and_says_so():
    """A still reference or response gives NaN and the reason."""
    moving, still = np.sin(TIME), np.full(TIME.size, 0.2)
    lag = lag_and_gain(still, moving, RATE)
    assert np.isnan(lag.lag_s) and np.isnan(lag.gain)
    assert lag.reason == "the reference never moves"
    assert lag_and_gain(moving, still, RATE).reason == "the response never moves"
    late = np.where(TIME[-3] < TIME, 1.0, 0.0)
    assert np.isnan(lag_and_gain(late, moving, RATE).lag_s)


def test_a_lag_beyond_the_search_is_not_a_number_at_its_edge():
    """A ramp-like move three seconds late is out of reach: NaN with the range, not the limit."""
    move = np.tanh(TIME - 3.0)
    lag = lag_and_gain(move, np.tanh(TIME - 6.0), RATE)
    assert np.isnan(lag.lag_s) and "no lag between -0.101 and 1 s" in lag.reason
    wide = lag_and_gain(move, np.tanh(TIME - 6.0), RATE, max_lag_s=4.0)
    assert wide.lag_s == pytest.approx(3.0, abs=1e-6)


def test_unusable_signals_are_refused():
    """Unequal length, NaN, too few samples, and a search longer than half the signal."""
    for reference, response, more in (
        (np.zeros(20), np.zeros(21), {}),
        (np.full(20, np.nan), np.zeros(20), {}),
        (np.zeros(15), np.zeros(15), {}),
        (TIME, TIME, {"max_lag_s": 6.0}),
        (TIME, TIME, {"max_lag_s": 0.0}),
    ):
        with pytest.raises(InputError):
            lag_and_gain(reference, response, RATE, **more)


@pytest.mark.parametrize("phase", [0.0, 1.0, 2.5, 4.0])
def test_a_strong_swing_on_top_does_not_stop_the_refinement(phase):
    """A swing of 3.1 Hz and 40 % on top: the lag of scipy's own fit of a sine, to 0.05 ms."""
    from scipy.optimize import curve_fit

    rate, lag = 1000.0, 0.0194
    time = np.arange(10_000) / rate
    response = np.sin(2 * np.pi * (time - lag)) + 0.4 * np.sin(2 * np.pi * 3.122 * time + phase)

    def model(t, late, gain, offset):
        return gain * np.sin(2 * np.pi * (t - late)) + offset

    used = time > lag  # where the shifted reference is known
    (expected, *_), _ = curve_fit(model, time[used], response[used], [lag, 1.0, 0.0])
    found = lag_and_gain(np.sin(2 * np.pi * time), response, rate)
    assert found.lag_s == pytest.approx(expected, abs=5e-5)
