"""Samples that answer with a spike: told from the others, which alone say what a fit knows."""

from __future__ import annotations

import numpy as np

from ecyl_ros.gap.fit.linear import linear_samples
from ecyl_ros.gap.inverse import inverse_of

SAMPLES, SPIKES = 4000, 20


def _slopes(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Derivatives by three unknowns over a short and a long step: alike but of the first samples,
    whose spikes a long step passes over."""
    time = np.linspace(0.0, 1.0, SAMPLES)
    tangents = np.stack([np.ones(SAMPLES), np.sin(9.0 * time), np.cos(14.0 * time)])
    secants = 1.01 * tangents
    tangents[:, :SPIKES] = 500.0 * rng.standard_normal((3, SPIKES))
    secants[:, :SPIKES] = 5.0 * rng.standard_normal((3, SPIKES))
    return tangents, secants


def test_spikes_do_not_count_and_all_others_do():
    """Each spike bends by more than its noise over what 3980 smooth samples leave open."""
    tangents, secants = _slopes(np.random.default_rng(3))
    found = linear_samples(tangents, secants, np.ones(SAMPLES), 30.0, np.zeros(3))
    assert not found[:SPIKES].any()
    assert found[SPIKES:].all()


def test_samples_that_alone_tell_an_unknown_count():
    """A hundred samples see a third unknown that no other does, and large as their answer is it is
    as large over a long step."""
    tangents, _ = _slopes(np.random.default_rng(3))
    tangents[:, :SPIKES] = 0.0
    tangents[2] = 0.0
    tangents[2, 500:600] = 500.0
    found = linear_samples(tangents, 1.001 * tangents, np.ones(SAMPLES), 30.0, np.full(3, 1e-6))
    assert found.all()


def test_a_spike_that_the_others_leave_no_room_for_counts():
    """It bends by less than its noise where the unknown is known to a thousandth of a unit."""
    tangents, secants = _slopes(np.random.default_rng(3))
    found = linear_samples(tangents, secants, np.ones(SAMPLES), 30.0, np.full(3, 1e10))
    assert found.all()


def test_what_a_step_finds_without_spikes_lies_in_its_interval():
    """Spikes that have moved on: a step with all samples stays put and is sure of itself."""
    rng = np.random.default_rng(4)
    (slopes, secants), truth = _slopes(rng), np.array([0.8, -0.5, 0.6])
    left = truth @ slopes + rng.standard_normal(SAMPLES)
    left[:SPIKES] = rng.standard_normal(SPIKES)  # after a unit's move no sample is where it was

    def step(counted: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        chosen = slopes[:, counted]
        open_ = inverse_of(chosen @ chosen.T)
        return open_ @ chosen @ left[counted], 1.96 * np.sqrt(np.diag(open_))

    found, half = step(
        linear_samples(slopes, secants, np.ones(SAMPLES), float(SAMPLES), np.zeros(3))
    )
    assert np.all(np.abs(found - truth) < 2.0 * half)
    stuck, sure = step(np.ones(SAMPLES, dtype=bool))
    assert np.all(np.abs(stuck) < 0.1) and np.all(sure < 0.1 * half)
