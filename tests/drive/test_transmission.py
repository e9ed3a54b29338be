"""Backlash and stiffness: equation (5) and its segments."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ecyl_ros.drive.drive_file import load_drive
from ecyl_ros.drive.packed import pack
from ecyl_ros.drive.transmission import beyond, contact_mode, mode_torque


def _params(
    damping: float = 0.0,
    stiffness=(100.0, 300.0, 900.0),
    breaks=(2.0, 5.0),
    backlash: float = 0.02,
):
    drive = load_drive("bench")
    transmission = dataclasses.replace(
        drive.transmission,
        backlash=backlash,
        stiffness=stiffness,
        stiffness_breaks=breaks,
        contact_damping=damping,
    )
    return pack(dataclasses.replace(drive, transmission=transmission))


def _torque(twist: float, rate: float, p) -> float:
    return mode_torque(twist, rate, contact_mode(twist, rate, p[0]), p[0])


def test_dead_zone_of_equation_5() -> None:
    """One stiffness C gives T = C (twist -+ alpha/2) outside the clearance and 0 inside."""
    p = _params(stiffness=(100.0,), breaks=())
    for twist, torque in ((0.0, 0.0), (0.0099, 0.0), (-0.0099, 0.0), (0.03, 2.0), (-0.05, -4.0)):
        assert _torque(twist, 0.0, p) == pytest.approx(torque, abs=1e-12)


def test_segments_meet_at_the_breaks_with_their_own_slope() -> None:
    """The torque curve is continuous and has stiffness k_j between the breaks, on both flanks."""
    p = _params()
    twist = np.linspace(-0.2, 0.2, 80_001)
    torque = np.array([_torque(x, 0.0, p) for x in twist])
    assert np.abs(np.diff(torque)).max() < 900.0 * np.diff(twist).max() * 1.001
    slope = np.diff(torque) / np.diff(twist)
    middle = 0.5 * np.abs(torque[1:] + torque[:-1])
    for low, high, stiffness in ((0.01, 1.9, 100.0), (2.1, 4.9, 300.0), (5.1, 50.0, 900.0)):
        inside = (middle > low) & (middle < high)
        np.testing.assert_allclose(slope[inside], stiffness, rtol=1e-6)
    np.testing.assert_allclose(torque, -torque[::-1], atol=1e-9)


@given(st.floats(-0.2, 0.2), st.floats(-1e3, 1e3))
def test_contact_never_pulls(twist: float, rate: float) -> None:
    """Whatever the damping, the torque pushes the flanks apart or is zero."""
    torque = _torque(twist, rate, _params(damping=0.5))
    assert torque * twist >= 0.0
    if abs(twist) <= 0.01:
        assert torque == 0.0


@given(st.floats(-0.01, 0.01), st.floats(-1e3, 1e3))
def test_without_clearance_the_contact_never_parts(twist: float, rate: float) -> None:
    """Preloaded flanks are a spring with its damper, both ways: C twist + D rate, in one mode."""
    p = _params(damping=0.5, backlash=0.0)
    assert contact_mode(twist, rate, p[0]) == 1
    assert _torque(twist, rate, p) == pytest.approx(100.0 * twist + 0.5 * rate, abs=1e-12)
    assert beyond(twist, rate, 1, p[0]) <= 0.0


@given(
    st.floats(-0.2, 0.2),
    st.floats(-1e3, 1e3),
    st.sampled_from(
        [(0.02, mode) for mode in range(-3, 4)] + [(0.0, m) for m in (-3, -2, 1, 2, 3)]
    ),
)
def test_a_motion_is_beyond_every_mode_but_its_own(
    twist: float, rate: float, clearance: tuple[float, int]
) -> None:
    """`beyond` is above 0 out of a mode and not above it within, up to rounding where two meet."""
    backlash, mode = clearance
    p = _params(damping=0.5, backlash=backlash)[0]
    own = contact_mode(twist, rate, p)
    assert beyond(twist, rate, own, p) <= 1e-15
    if mode != own:
        assert beyond(twist, rate, mode, p) >= -1e-15


def test_the_end_of_a_mode_is_told_steadily() -> None:
    """Along a motion through all segments `beyond` a mode changes no faster than the twist."""
    p = _params()[0]
    twist = np.linspace(-0.2, 0.2, 40_001)
    for mode in range(-3, 4):
        told = np.array([beyond(x, 0.0, mode, p) for x in twist])
        assert np.abs(np.diff(told)).max() <= 1.01 * np.diff(twist).max()
