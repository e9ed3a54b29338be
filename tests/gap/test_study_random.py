"""Random drives of the sealed study: stable, within their ranges, true to physics, visible."""

from __future__ import annotations

import dataclasses
import math
from collections import Counter

import numpy as np
import pytest

from ecyl_ros.drive.drive_file import drive_from_flat, drive_to_flat
from ecyl_ros.drive.engine import VOLTAGE, simulate
from ecyl_ros.drive.parameters import SensorParameters
from ecyl_ros.drive.stability import is_stable
from ecyl_ros.gap.study.case import Case
from ecyl_ros.gap.study.cylinder.cases import VISIBLE
from ecyl_ros.gap.study.cylinder.excitation import draw_reference
from ecyl_ros.gap.study.cylinder.machine import noise_floor, run_machine
from ecyl_ros.gap.study.cylinder.nuisances import Nuisances, steps_of
from ecyl_ros.gap.study.cylinder.physics import nominal_physics
from ecyl_ros.gap.study.drives import RandomDrives
from ecyl_ros.gap.study.random_drives import draw_setup
from ecyl_ros.gap.study.seal import seal

SETUPS = [draw_setup(seed) for seed in range(60)]


def _spread(values):
    return max(values) / min(values)


def test_every_drive_is_stable_and_a_possible_drive_file() -> None:
    """Each passes the stability check of the product and its drive file reader."""
    for setup in SETUPS:
        assert is_stable(setup.drive)
        again = drive_from_flat(drive_to_flat(setup.drive), "again")
        assert again.motor == setup.drive.motor
        assert again.controller == setup.drive.controller


def test_drives_cover_their_ranges() -> None:
    """Lead 2 to 40 mm, ratio 1 to 5, inertia over almost three decades, control at 4 to 20 kHz,
    logged at 250 to 2000 Hz with whole ticks between; every signal is missing now and then."""
    drives = [setup.drive for setup in SETUPS]
    leads = [one.transmission.lead for one in drives]
    assert 2e-3 <= min(leads) < 4e-3 and 25e-3 < max(leads) <= 40e-3
    assert {1.0 <= one.transmission.gear_ratio <= 5.0 for one in drives} == {True}
    assert _spread([one.motor.rotor_inertia for one in drives]) > 300.0
    assert {4e3 <= one.controller.rate <= 2e4 for one in drives} == {True}
    assert len({one.controller.rate for one in drives}) == 6
    for one in drives:
        assert 250.0 <= one.sample_rate <= 2000.0
        ticks = one.controller.rate / one.sample_rate
        assert ticks == pytest.approx(one.telemetry_every, rel=1e-12)
    assert _spread([one.sensors.rotor_position_noise for one in drives]) > 5.0
    missing = Counter(name for setup in SETUPS for name in setup.missing)
    assert set(missing) == {"voltage_q_v", "rod_position_m", "rotor_velocity_rad_per_s"}
    assert sum(not setup.missing for setup in SETUPS) > 30


def test_drives_are_built_as_drives_are() -> None:
    """Torque and back-EMF constants differ by a convention of dq currents alone, L/R is 0.5 to
    5 ms, the contact resonates at 150 to 800 Hz with 2 to 8 % damping, bandwidths are in order."""
    for setup in SETUPS:
        drive = setup.drive
        motor, screw, control = drive.motor, drive.transmission, drive.controller
        ratio = motor.torque_constant / motor.back_emf_constant
        assert min(abs(ratio - one) for one in (1.0, 1.5, 3.0)) < 1e-9
        assert 0.5e-3 <= motor.inductance / motor.resistance <= 5e-3
        inertia = 1.0 / (1.0 / motor.rotor_inertia + 1.0 / drive.load.inertia)
        resonance = math.sqrt(screw.stiffness[-1] / inertia)
        assert 150.0 <= resonance / math.tau <= 800.0
        damping = screw.contact_damping / (2.0 * math.sqrt(screw.stiffness[-1] * inertia))
        assert 0.02 <= damping <= 0.08
        position = control.position.kp
        whole = motor.rotor_inertia + drive.load.inertia
        speed = control.speed.kp * motor.torque_constant / whole
        current = control.current.kp / motor.inductance
        assert 3.0 <= position / math.tau <= 15.0
        assert 3.0 * position < speed < 0.5 * current
        assert current / math.tau <= min(1500.0, control.rate / 12.0) * (1.0 + 1e-9)


def test_a_random_machine_is_its_nominal_model() -> None:
    """Without effects the study's equations give what the product's engine gives, from the same
    reference at every tick, within a quarter of the noise floor."""
    setup = SETUPS[10]
    drive = dataclasses.replace(setup.drive, telemetry_rate=setup.drive.controller.rate)
    tick = 1.0 / drive.controller.rate
    speed = setup.peak_speed * drive.transmission.rod_per_rotor
    position, velocity = draw_reference(np.random.default_rng(5), 3.0, tick, speed)
    plain = Nuisances(steps_of(drive), 0.0, 0.0, 0, 0)
    run = run_machine(nominal_physics(drive), plain, drive, (position, velocity))
    asked = np.append(position, position[-1]), np.append(velocity, 0.0)
    quiet = dataclasses.replace(drive, sensors=SensorParameters())
    model = simulate(quiet, lambda index: (asked[0][index], asked[1][index]), 3.0)
    for name, floor in noise_floor(drive).items():
        values = model.samples[:, VOLTAGE + 1] if name == "voltage_q_v" else model.signal(name)
        gap = run.signals[name] - values[: len(run.time_s)]
        assert np.sqrt(np.mean(gap**2)) < 0.25 * floor, name


def test_effects_show_in_what_is_recorded() -> None:
    """On a drive whose log lacks a signal, the effect's gap is counted in the others and visible
    there; the recording lacks it, and the label carries the drive."""
    seed = next(seed for seed, setup in enumerate(SETUPS) if "rod_position_m" in setup.missing)
    drives = RandomDrives(0.02)
    planned = Case(0, seed, "single", {"resistance_error": {}}, drives="random", sheet=0.02)
    case = drives.complete(planned)
    given = drives.given(case)
    assert case.seed == seed
    assert "rod_position_m" not in case.gaps["resistance_error"]
    assert max(case.gaps["resistance_error"].values()) >= VISIBLE
    assert not given.recording.has("rod_position_m")
    assert given.recording.has("rotor_position_rad")
    assert given.recording.rate_hz == pytest.approx(given.drive.sample_rate, rel=1e-3)
    assert case.facts["missing"] == ["rod_position_m"]
    assert case.facts["drive"]["transmission.lead"] == given.drive.transmission.lead
    assert seal([case]).open() == [case]


def test_what_no_recorded_signal_shows_is_drawn_on_another_drive() -> None:
    """A wrong lead shows on the rod alone: without its scale the case moves on to another seed."""
    seed = next(
        seed
        for seed, setup in enumerate(SETUPS[:-1])
        if "rod_position_m" in setup.missing and "rod_position_m" not in SETUPS[seed + 1].missing
    )
    planned = Case(0, seed, "single", {"lead_error": {}}, drives="random")
    assert RandomDrives().complete(planned).seed > seed
