"""Rigid drives off their sheet: constants, a gain and a lag that are no cause, and what is one."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from rigid_machines import LINEAR, RATE_HZ, ROTARY, Motion, motion, recorded

from ecyl_ros.drive.rigid.machine_file import load_machine
from ecyl_ros.gap.diagnose import diagnose
from ecyl_ros.gap.twin.closer import write_twin

M = motion(0.1)
S = np.sign(M.v)
SHEET = dataclasses.replace(LINEAR, viscous=40.0, coulomb=6.0, tolerances={"all": 0.1})


def _drag(mass: float = 20.0, viscous: float = 40.0, coulomb: float = 6.0) -> np.ndarray:
    return mass * M.a + viscous * M.v + coulomb * S


def test_constants_within_their_tolerances_are_no_cause() -> None:
    """Mass 6 % up, friction 7 % down: within the sheet, the constants found within 2 %."""
    result = diagnose(recorded(M, _drag(21.2, 37.2, 5.6), SHEET, 0.3, 1e-6), SHEET)
    assert result.verdict == "within_sheet" and not result.causes
    found = {one.parameter: one for one in result.sheet}
    for key, true in (
        ("load.mass", 21.2),
        ("load.viscous_friction", 37.2),
        ("load.coulomb_friction", 5.6),
    ):
        assert found[key].value == pytest.approx(true, rel=0.02)
        assert found[key].low <= true <= found[key].high
    # The replay beside is one with the constants as found.
    assert all(one.after < 0.3 * one.gap for one in result.signals if not one.judged)


def test_a_known_push_from_outside_is_no_gap() -> None:
    """10 N for a quarter of each second: no cause where they were recorded, a gap where not."""
    push = np.where(np.mod(M.t, 1.0) < 0.25, 10.0, 0.0)
    blind = recorded(M, _drag() - push, SHEET, 0.3, 1e-6)
    told = diagnose(dataclasses.replace(blind, injected_force_n=push), SHEET)
    assert told.verdict in ("no_gap", "within_sheet") and not told.causes
    assert diagnose(blind, SHEET).verdict not in ("no_gap", "within_sheet")


def test_a_constant_that_has_to_leave_its_tolerance_is_a_cause() -> None:
    """A mass 40 % up with friction 5 % down: the mass alone is named, with its value."""
    result = diagnose(recorded(M, _drag(28.0, 38.0, 5.7), SHEET, 0.3, 1e-6), SHEET)
    assert [one.effect for one in result.causes] == ["load_inertia_error"]
    assert result.causes[0].parameters[0].value == pytest.approx(28.0, rel=0.02)


@pytest.mark.parametrize("fault", [0.0, 5.0])
def test_an_unknown_gain_is_found_with_the_values_of_the_file(tmp_path, fault) -> None:
    """Mass and friction stated, force per ampere not: they tell it, and more friction is seen."""
    machine = dataclasses.replace(SHEET, actuation="current", gain=None)
    current = (_drag() + fault * S) / 8.0
    body = (
        "/**:\n  ros__parameters:\n    drive: {kind: rigid, output: linear}\n"
        "    actuation: {signal: current}\n"
        "    load: {mass: 20.0, viscous_friction: 40.0, coulomb_friction: 6.0}\n"
        "    tolerances: {all: 0.1}\n"
    )
    path = tmp_path / "drive.yaml"
    path.write_text(body, encoding="utf-8")
    recording = recorded(M, current, machine, 0.03, 1e-6)
    result = diagnose(recording, load_machine(path))
    if not fault:
        assert result.verdict in ("no_gap", "within_sheet") and not result.causes
        gain = {one.name: one for one in result.measured}["torque_constant_n_per_a"]
        assert gain.low <= 8.0 <= gain.high and gain.value == pytest.approx(8.0, rel=0.03)
        return
    assert [one.effect for one in result.causes] == ["load_coulomb_friction"]
    assert result.causes[0].parameters[0].name == "coulomb_a"
    assert result.causes[0].parameters[0].value == pytest.approx(fault / 8.0, rel=0.05)
    write_twin(result, path, tmp_path / "twin.yaml")
    again = diagnose(recording, load_machine(tmp_path / "twin.yaml"))
    assert again.verdict in ("no_gap", "within_sheet")


def test_noise_of_the_encoder_makes_no_mass_smaller() -> None:
    """Steps of 20 um at 1 kHz, differentiated twice: the mass is found within its interval."""
    unknown = dataclasses.replace(LINEAR, inertia=None)
    result = diagnose(recorded(M, 20.0 * M.a, unknown, 0.3, 2e-5), unknown)
    mass = {one.name: one for one in result.measured}["mass_kg"]
    assert mass.low <= 20.0 <= mass.high
    assert mass.value == pytest.approx(20.0, rel=0.02)


def _late(effort: np.ndarray, seconds: float) -> np.ndarray:
    """Effort whose motion comes later by `seconds`."""
    return np.interp(M.t + seconds, M.t, effort)


@pytest.mark.parametrize("samples", [-1.7, 1.4])
def test_a_lag_of_sampling_is_taken_out_silently(samples) -> None:
    """Effort up to two samples off the motion, at 100 Hz: no gap, whichever way."""
    every = 10
    slow = Motion(M.t[::every], M.q[::every], M.v[::every], M.a[::every])
    effort = _late(_drag(), samples * every / RATE_HZ)[::every]
    result = diagnose(recorded(slow, effort, SHEET, 0.3, 1e-6), SHEET)
    assert result.verdict in ("no_gap", "within_sheet") and not result.causes


def test_noise_of_the_effort_is_no_lag() -> None:
    """A third of the effort is noise: what is left is the same with a lag and without one."""
    every, left = 10, []
    slow = Motion(M.t[::every], M.q[::every], M.v[::every], M.a[::every])
    for samples in (-1.9, 0.0, 1.9):
        effort = _late(_drag(), samples * every / RATE_HZ)[::every]
        result = diagnose(recorded(slow, effort, SHEET, 8.0, 1e-6), SHEET)
        assert result.verdict == "no_gap"
        left.append(next(one.gap for one in result.signals if one.name == "force"))
    assert max(left) < 1.02 * min(left)


def test_a_long_delay_is_found_as_long_as_it_is() -> None:
    """25 ms, far beyond what a first derivative holds: named, within sampling's own lag."""
    result = diagnose(recorded(M, _late(_drag(), 0.025), SHEET, 0.3, 1e-6), SHEET)
    assert [one.effect for one in result.causes] == ["actuation_delay"]
    assert result.causes[0].parameters[0].value == pytest.approx(0.025, abs=0.0025)


def test_a_line_that_comes_and_goes_is_no_disturbance() -> None:
    """Another axis that pushes at 3.3 Hz for a third of the time: a gap, not a disturbance."""
    inside = (M.t > 4.0) & (M.t < 11.0)
    push = 6.0 * np.sin(2.0 * np.pi * 3.3 * M.t) * inside
    exact = dataclasses.replace(LINEAR, tolerances={"all": "exact"})
    result = diagnose(recorded(M, 20.0 * M.a + push, exact, 0.3, 1e-6), exact)
    assert "periodic_disturbance" not in [one.effect for one in result.causes]
    assert result.verdict not in ("no_gap", "within_sheet")


def test_a_weight_on_an_output_that_goes_round_is_seen() -> None:
    """Once per turn over eight turns: named as a weight, and what else it may be."""
    turning = motion(12.0)
    effort = 0.02 * turning.a + 0.4 * np.sin(turning.q + 0.3)
    result = diagnose(recorded(turning, effort, ROTARY, 0.02, 1e-4), ROTARY)
    assert [one.effect for one in result.causes] == ["gravity_on_arm"]
    assert result.causes[0].parameters[0].value == pytest.approx(0.4, rel=0.03)
    assert "cogging_torque" in result.causes[0].alternatives
