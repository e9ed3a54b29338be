import numpy as np
import pytest

from ecyl_ros.analysis.emd import EmdSettings, decompose, hilbert_frequency
from ecyl_ros.errors import InputError

RATE = 1000.0
TIME = np.arange(10_000) / RATE


def test_two_sines_come_apart():
    """Sines of 3.45 and 1 Hz, as in the paper, become IMF1 and IMF2; FFT and Hilbert agree."""
    fast, slow = 6e-6 * np.sin(2 * np.pi * 3.45 * TIME), 4e-6 * np.sin(2 * np.pi * TIME)
    result = decompose(fast + slow, RATE)
    first, second = result.imfs[:2]
    assert first.frequency_hz == pytest.approx(3.45, abs=0.01)
    assert second.frequency_hz == pytest.approx(1.0, abs=0.01)
    assert first.hilbert_frequency_hz == pytest.approx(3.45, abs=0.05)
    assert second.hilbert_frequency_hz == pytest.approx(1.0, abs=0.05)
    assert first.amplitude == pytest.approx(6e-6, rel=0.03)
    assert second.amplitude == pytest.approx(4e-6, rel=0.03)
    assert first.std == pytest.approx(6e-6 / np.sqrt(2), rel=0.03)


def test_modes_and_residue_add_up_to_the_signal():
    """The sum of all parts is the low-passed signal: to rounding, and to noise for the signal."""
    rng = np.random.default_rng(1)
    clean = np.sin(2 * np.pi * 2 * TIME) + 0.3 * TIME
    result = decompose(clean + 1e-3 * rng.normal(size=TIME.size), RATE)
    total = result.residue + sum(imf.values for imf in result.imfs)
    inner = slice(50, -50)
    np.testing.assert_allclose(total[inner], clean[::2][inner], atol=2e-3)
    assert len(result.imfs) <= 5


def test_the_scale_of_the_signal_does_not_matter():
    """Micrometres give the same modes as metres, whatever absolute thresholds PyEMD has."""
    values = np.sin(2 * np.pi * 3 * TIME) + np.sin(2 * np.pi * 0.7 * TIME) ** 3
    large, small = decompose(values, RATE), decompose(1e-9 * values, RATE)
    assert len(large.imfs) == len(small.imfs)
    for one, other in zip(large.imfs, small.imfs, strict=True):
        np.testing.assert_allclose(other.values, 1e-9 * one.values, atol=1e-15)


def test_thinning_out_is_stated_and_keeps_the_band():
    """A 20 kHz signal comes down to 500 Hz; a line in the band stays, one above does not fold."""
    time = np.arange(100_000) / 20_000
    inside = np.sin(2 * np.pi * 20 * time)
    alias = np.sin(2 * np.pi * 497 * time)  # would show at 3 Hz
    result = decompose(inside + alias, 20_000.0)
    assert (result.rate_hz, result.lowpass_hz) == (500.0, 37.5)
    assert result.imfs[0].frequency_hz == pytest.approx(20, abs=0.01)
    assert result.imfs[0].amplitude == pytest.approx(1.0, rel=0.01)
    assert all(imf.std < 5e-3 for imf in result.imfs[1:])


def test_slow_recordings_are_taken_as_they_are():
    """Where the low-pass would lie above half the rate there is none."""
    result = decompose(np.sin(2 * np.pi * 2 * np.arange(500) / 50), 50.0)
    assert (result.rate_hz, result.lowpass_hz) == (50.0, None)
    assert result.imfs[0].frequency_hz == pytest.approx(2.0, abs=0.01)


def test_a_mode_too_slow_for_its_frequency_has_none():
    """A mode with fewer than three periods in the signal has a spread, but NaN for its line."""
    result = decompose(np.sin(2 * np.pi * 3 * TIME) + 5 * np.sin(2 * np.pi * 0.12 * TIME), RATE)
    slow = max(result.imfs[1:], key=lambda imf: imf.std)
    assert slow.std > 2.0 and np.isnan(slow.frequency_hz) and np.isnan(slow.amplitude)


def test_signals_that_cannot_be_decomposed():
    """NaN and short signals are refused; a constant has no modes."""
    with pytest.raises(InputError, match="finite"):
        decompose(np.array([np.nan] * 100), RATE)
    with pytest.raises(InputError, match="16 samples"):
        decompose(np.zeros(15), RATE)
    constant = decompose(np.full(100, 2.0), RATE)
    assert constant.imfs == ()


def test_hilbert_frequency_weighs_by_power():
    """Half the time 2 Hz at amplitude 3, half 8 Hz at 1: (9 x 2 + 1 x 8) / 10 = 2.6 Hz."""
    half = TIME.size // 2
    values = np.where(
        np.arange(TIME.size) < half,
        3.0 * np.sin(2 * np.pi * 2 * TIME),
        np.sin(2 * np.pi * 8 * TIME),
    )
    assert hilbert_frequency(values, RATE) == pytest.approx(2.6, abs=0.1)


def test_settings_limit_the_number_of_modes():
    """max_imfs modes at most, and the settings come back with the result."""
    rng = np.random.default_rng(2)
    settings = EmdSettings(max_imfs=2)
    result = decompose(rng.normal(size=2000), 100.0, settings)
    assert len(result.imfs) == 2 and result.settings == settings


def test_overlapping_modes_are_told_by_their_energy():
    """Two clean sines come apart with energies that add up; a made-up overlap shows as more."""
    from dataclasses import replace

    result = decompose(np.sin(2 * np.pi * 3.45 * TIME) + np.sin(2 * np.pi * TIME), RATE)
    assert result.energy_ratio == pytest.approx(1.0, abs=0.03)
    first, *rest = result.imfs
    # The same sum, with the first mode split into twice itself and its negative.
    shared = tuple(replace(first, values=k * first.values) for k in (2.0, -1.0))
    assert replace(result, imfs=(*shared, *rest)).energy_ratio > 2.5


def test_clean_modes_are_neither_mixed_nor_ruled_by_the_ends():
    """Two sines in their own modes: under 1 % of their power elsewhere, under 10 % changed."""
    result = decompose(np.sin(2 * np.pi * 3.45 * TIME) + np.sin(2 * np.pi * TIME + 0.3), RATE)
    for imf in result.imfs[:2]:
        assert imf.mixed < 0.01
        assert imf.edge_change < 0.1


def test_mode_mixing_is_told():
    """A 10 Hz burst on a 1 Hz sine, the textbook case: IMF1 holds the burst and parts of the sine,
    more than 15 % of its power away from its line."""
    burst = np.where((TIME > 4.0) & (TIME < 5.0), 0.3, 0.0) * np.sin(2 * np.pi * 10.0 * TIME)
    first = decompose(np.sin(2 * np.pi * TIME) + burst, RATE).imfs[0]
    assert first.mixed > 0.15


def test_modes_that_the_ends_make_are_told():
    """A random walk's slow modes have few extrema: cutting 7 % off the ends changes one of them by
    more than 30 %; the sum of all stays the signal."""
    walk = np.cumsum(np.random.default_rng(4).normal(size=4000))
    result = decompose(walk, 100.0)
    assert max(imf.edge_change for imf in result.imfs if np.isfinite(imf.edge_change)) > 0.3


def test_a_signal_too_short_or_too_slow_for_a_line_is_refused():
    """1 Hz needs 3 s and more than 2 Hz of sampling; modes are taken up to band_hz."""
    values = np.sin(2 * np.pi * TIME)
    with pytest.raises(InputError, match=r"2\.9 s is too short for a line at 1 Hz.*needs 3 s"):
        decompose(values[:2900], RATE, line_hz=1.0)
    assert decompose(values[:3000], RATE, line_hz=1.0).imfs
    with pytest.raises(InputError, match="expected at most the 25 Hz"):
        decompose(values, RATE, line_hz=30.0)
    with pytest.raises(InputError, match="more than 0"):
        decompose(values, RATE, line_hz=0.0)
