"""Stretches in which a logger repeats its last row, against ones that were put in."""

from __future__ import annotations

import numpy as np
import pytest
from rigid_machines import LINEAR, motion, recorded

from ecyl_ros.gap.diagnose import diagnose
from ecyl_ros.gap.rigid.frozen import without_repeats
from ecyl_ros.recording.repeats import repeated_rows
from ecyl_ros.recording.signals import Recording

M = motion(0.1)


def _frozen(recording: Recording, spans: list[tuple[int, int]]) -> Recording:
    kept = np.arange(recording.stamp_ns.size)
    for begin, end in spans:
        kept[begin:end] = begin
    return Recording(
        stamp_ns=recording.stamp_ns,
        rod_position_m=recording.rod_position_m[kept],
        rod_force_n=recording.rod_force_n[kept],
    )


def test_frozen_rows_are_found_where_they_were_put() -> None:
    """Two stretches that touch and a short one: their rows and no others."""
    spans = [(6000, 6250), (6250, 6500), (12000, 12030)]
    recording = _frozen(recorded(M, 20.0 * M.a, LINEAR, 0.3, 1e-6), spans)
    rows = np.isnan(without_repeats(recording)[0].rod_force_n)
    expected = np.zeros(M.t.size, dtype=bool)
    for begin, end in spans:
        expected[begin:end] = True
    assert np.array_equal(rows, expected)


def test_a_drive_at_rest_is_not_frozen() -> None:
    """Coarse counts of a drive that stops and starts again stand still together, rightly."""
    time = np.arange(20000) / 1000.0
    speed = np.clip(np.sin(0.5 * np.pi * time), 0.0, None)  # rests every other 2 s
    counts = np.round(np.cumsum(speed) * 1e-4 / 1e-3) * 1e-3
    effort = np.round(3.0 * speed + 0.5 * (speed > 0.0), 1)
    assert not repeated_rows({"rod_position_m": counts, "rod_force_n": effort}).any()


def test_a_frozen_logger_makes_no_gap() -> None:
    """Half a second frozen in full motion: no gap with a healthy machine, and a note on it."""
    recording = _frozen(recorded(M, 20.0 * M.a, LINEAR, 0.3, 1e-6), [(9000, 9500)])
    result = diagnose(recording, LINEAR)
    assert result.verdict == "no_gap"
    assert any("repeats one sample from 9.000 to 9.499 s" in note for note in result.notes)


def test_friction_keeps_its_value_beside_frozen_stretches() -> None:
    """The level that was put in, within 2 %, from what was recorded between three of them."""
    spans = [(3000, 3400), (9000, 9500), (15000, 15300)]
    recording = _frozen(recorded(M, 20.0 * M.a + 9.0 * np.sign(M.v), LINEAR, 0.3, 1e-6), spans)
    result = diagnose(recording, LINEAR)
    assert [one.effect for one in result.causes] == ["load_coulomb_friction"]
    assert result.causes[0].parameters[0].value == pytest.approx(9.0, rel=0.02)
