"""Whether a law predicts by chance."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

from ecyl_ros.gap.describe.chance import LEVEL, by_pieces, by_stretches, pieces, probability

_STRETCHES, _EACH = 24, 100
_STRETCH = np.repeat(np.arange(_STRETCHES), _EACH)


def _wander(rng: np.random.Generator, samples: float, signals: int = 1) -> np.ndarray:
    """Noise whose correlation falls to 1/e in so many samples: float64[signals, n]."""
    fall = np.exp(-1.0 / samples)
    start = int(10.0 * samples)
    white = rng.standard_normal((signals, start + _STRETCH.size))
    found: np.ndarray = lfilter([np.sqrt(1.0 - fall**2)], [1.0, -fall], white)[:, start:]
    return found


def _of(before: np.ndarray, after: np.ndarray, sets: int) -> float:
    """Of what is left on each stretch, the same all along it."""
    missing, left = (np.sqrt(one)[_STRETCH][np.newaxis] for one in (before, after))
    return probability(missing, left, _STRETCH, 1.0, sets)


def test_a_law_that_helps_in_one_stretch_is_by_chance() -> None:
    """Over 24 stretches: half as much left in each is sure, as 24 heads in a row are, in one it is
    not; a stretch beyond all others, where the law is unknown, denies nothing; the number of sets
    that were looked at counts; perfect data end in no warning."""
    rng = np.random.default_rng(2)
    before = rng.uniform(1.0, 3.0, _STRETCHES)
    everywhere = 0.5 * before * rng.uniform(0.8, 1.2, _STRETCHES)
    once = np.where(np.arange(_STRETCHES) == 5, 0.01, 1.0) * before * rng.uniform(0.9, 1.1, 24)
    assert _of(before, everywhere, 1) == pytest.approx(2.0 * 0.5**24)
    assert _of(before, once, 1) > LEVEL
    beyond = np.where(np.arange(_STRETCHES) == 11, 100.0 * before, everywhere)
    assert _of(before, beyond, 1) < 1e-4
    assert _of(before, everywhere, 4) == pytest.approx(8.0 * 0.5**24)
    worse = before * rng.uniform(0.9, 1.4, _STRETCHES)
    assert _of(before, worse, 1) > 0.9
    assert _of(before, before, 1) == 1.0
    some = np.where(np.arange(_STRETCHES) < 12, 0.0, everywhere)
    assert 0.0 <= _of(before, some, 1) < LEVEL


def test_a_law_that_acts_in_some_stretches_is_not_by_chance() -> None:
    """A law that is all that is missing in 8 stretches of 24, and noise and its own error in the
    others, which the ranks of stretches cannot tell from chance."""
    rng = np.random.default_rng(4)
    noise = rng.standard_normal((2, _STRETCH.size))
    law = 6.0 * _wander(rng, 20.0, 2) * (_STRETCH % 3 == 0)
    off = 0.4 * rng.standard_normal((2, _STRETCH.size))
    missing, left = noise + law, noise + off
    assert by_stretches(missing, left, _STRETCH) > LEVEL
    assert probability(missing, left, _STRETCH, 1.0, 10) < 1e-4
    apart = missing - np.roll(law, 3 * _EACH // 2, axis=1)
    assert probability(missing, apart, _STRETCH, 1.0, 10) > 0.5


@pytest.mark.parametrize(
    ("missing", "law"), [(0.1, 0.1), (30.0, 30.0), (300.0, 30.0), (300.0, 300.0), (3000.0, 3000.0)]
)
@pytest.mark.parametrize("size", [0.1, 1.0])
def test_pieces_keep_their_level_however_it_wanders(
    missing: float, law: float, size: float
) -> None:
    """What wanders without a connection, as fast or as slowly as it likes: a probability of at most
    p comes with a probability of at most p."""
    rng = np.random.default_rng(6)
    found = []
    for _ in range(300):
        there = 3.0 * _wander(rng, missing) + 0.5 * rng.standard_normal((1, _STRETCH.size))
        found.append(by_pieces(there, there - size * _wander(rng, law), 1.0))
    for level in (0.01, 0.05, 0.2):
        by_luck = 3.0 * np.sqrt(level * (1.0 - level) / len(found))
        assert np.mean(np.array(found) <= level) <= level + by_luck


def test_what_wanders_as_a_whole_is_one_piece() -> None:
    """A constant, and a drift, beside white noise that is many."""
    rng = np.random.default_rng(8)
    one, drift = np.ones((1, _STRETCH.size)), np.linspace(0.0, 1.0, _STRETCH.size)[np.newaxis]
    white = rng.standard_normal((1, _STRETCH.size))
    assert pieces(one, one) == 1
    assert pieces(drift, one) == 1
    assert pieces(white, rng.standard_normal(white.shape)) > 0.5 * _STRETCH.size
    assert pieces(0.0 * one, one) == 1
