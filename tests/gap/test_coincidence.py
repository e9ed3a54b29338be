"""Causes that agree in their factor stand for one fault of another kind."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from sheets import exact

from ecyl_ros.drive.engine import simulate
from ecyl_ros.drive.reference.sine import Sine
from ecyl_ros.gap.diagnose import diagnose
from ecyl_ros.gap.judge.coincidence import coincidence
from ecyl_ros.gap.replay.replay import SIGNALS
from ecyl_ros.gap.replay.sensor_noise import declared_noise
from ecyl_ros.gap.study.cylinder.cases import Case, record_case

GAIN = 0.2


@pytest.fixture(scope="module")
def drive():
    """The bench drive."""
    return exact("bench")


def alias(drive, factor: float = 1.0 + GAIN) -> dict[str, dict[str, float]]:
    """Three faults that make what a current read `factor` times too large makes."""
    motor = drive.motor
    return {
        "torque_constant_error": {"torque_constant_nm_per_a": motor.torque_constant / factor},
        "inverter_gain": {"gain": factor - 1.0},
        "back_emf_error": {"back_emf_v_s_per_rad": motor.back_emf_constant * factor},
    }


def test_a_wrong_current_reading_is_three_wrong_constants(drive) -> None:
    """L di/dt = u - R i - Ke w, Kt i in another unit of current: half a noise at most."""
    quiet = dataclasses.replace(drive, sensors=type(drive.sensors)())
    sine = Sine(amplitude=5e-3, frequency=1.0)
    runs = [
        simulate(
            dataclasses.replace(quiet, effects=effects),
            lambda i: sine.sample(i / drive.sample_rate),
            1.0,
        )
        for effects in ({"current_sensor_gain": {"gain": GAIN}}, alias(drive))
    ]
    noise = declared_noise(drive)
    for one in SIGNALS:
        first, other = (run.samples[:, one.column] for run in runs)
        assert np.abs(first - other).max() < 0.5 * noise[one.name], one.name
        assert np.abs(first).max() > 100.0 * noise[one.name]


def test_agreement_is_told_from_independent_faults(drive) -> None:
    """The three of the alias agree, also within what a fit leaves; others do not."""
    found = coincidence(alias(drive), drive)
    assert found is not None
    assert set(found.effects) == set(alias(drive))
    assert found.factor == pytest.approx(1.0 + GAIN)
    near = alias(drive)
    near["inverter_gain"] = {"gain": GAIN + 0.004}
    assert coincidence(near, drive) is not None
    apart = {"inverter_gain": {"gain": 0.2}, "resistance_error": {"resistance_ohm": 1.0}}
    assert coincidence(apart, drive) is None
    units = {  # agree by chance alone: no unit has both
        "load_inertia_error": {"inertia_kg_m2": 1.2 * drive.load.inertia},
        "resistance_error": {"resistance_ohm": 1.2 * drive.motor.resistance},
    }
    assert coincidence(units, drive) is None
    alone = {name: alias(drive)[name] for name in ("inverter_gain",)}
    assert coincidence(alone, drive) is None
    assert coincidence({"load_coulomb_friction": {"coulomb_nm": 0.1}}, drive) is None


def test_three_that_agree_within_their_tolerances_are_one_fault(drive) -> None:
    """Beside constants that are 2 % off their sheet the factors of the alias differ as much: with
    tolerances of 4 % the three are one fault still; two of them are not, and exact ones neither."""
    motor = drive.motor
    off = alias(drive)
    off["back_emf_error"] = {"back_emf_v_s_per_rad": 1.02 * (1.0 + GAIN) * motor.back_emf_constant}
    off["torque_constant_error"] = {
        "torque_constant_nm_per_a": 1.02 * motor.torque_constant / (1.0 + GAIN)
    }
    known = {"motor.torque_constant": 0.04, "motor.back_emf_constant": 0.04}
    assert coincidence(off, drive) is None
    found = coincidence(off, drive, known)
    assert found is not None and set(found.effects) == set(off)
    del off["inverter_gain"]
    assert coincidence(off, drive, known) is None


def test_weak_magnets_are_no_coincidence(drive) -> None:
    """Torque constant and back EMF lower by one share are both truly so."""
    motor = drive.motor
    weak = {
        "torque_constant_error": {"torque_constant_nm_per_a": 0.9 * motor.torque_constant},
        "back_emf_error": {"back_emf_v_s_per_rad": 0.9 * motor.back_emf_constant},
    }
    assert coincidence(weak, drive) is None
    weak["back_emf_error"] = {"back_emf_v_s_per_rad": motor.back_emf_constant / 0.9}
    assert coincidence(weak, drive) is not None


def test_a_wrong_current_reading_out_of_reach_is_laid_to_the_sensor_and_not_named(drive) -> None:
    """Another make of machine, its fault withheld: no cause is named, and the law that is found
    is an error of the current's reading in proportion to it."""
    case = Case(0, 29, "outside", {"x_current_sensor_gain": {"gain_error": GAIN}})
    found = diagnose(
        record_case(case, drive).slice(0.0, 3.2), drive, without=["current_sensor_gain"]
    )
    assert not found.causes
    assert found.verdict == "described" and found.law is not None
    law = found.law.as_json()
    assert law["port"] == "current_error" and law["of"][0] == "current"
    assert float(law["formula"].split()[0]) == pytest.approx(GAIN, rel=0.01)
    assert found.block == "sensor"
