"""Machines off their data sheet: drawn as stated, under a controller that believes the sheet."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from ecyl_ros.drive.drive_file import drive_from_flat, drive_to_flat, load_drive
from ecyl_ros.drive.tolerances import half_widths
from ecyl_ros.gap.study.case import Case
from ecyl_ros.gap.study.cylinder.cases import complete_case, stated
from ecyl_ros.gap.study.cylinder.machine import run_machine
from ecyl_ros.gap.study.cylinder.nuisances import Nuisances
from ecyl_ros.gap.study.cylinder.physics import nominal_physics
from ecyl_ros.gap.study.cylinder.sheet import (
    draw_errors,
    draw_feed,
    leaving_the_sheet,
    off_sheet,
    stated_tolerances,
    true_constants,
)
from ecyl_ros.gap.study.cylinder.stage import Setup, Stage

DRIVE = load_drive("bench")
CONSTANTS = {  # of the bench drive file
    "motor.resistance": 0.73,
    "motor.inductance": 2.26e-3,
    "motor.torque_constant": 0.716,
    "motor.back_emf_constant": 0.167,
    "motor.rotor_inertia": 4.45e-4,
    "motor.viscous_friction": 2e-3,
    "transmission.lead": 0.02,
    "transmission.backlash": 5.861356e-3,
    "transmission.stiffness": 6498.0,
    "transmission.contact_damping": 0.15,
    "load.inertia": 1.783e-3,
    "load.viscous_friction": 1e-2,
}


def test_errors_have_the_stated_spread() -> None:
    """Over 4000 machines each constant's error has mean 0, the standard deviation asked for (the
    lead's 1e-4), 95 % within the stated tolerance, and nothing to do with its neighbours'."""
    rng = np.random.default_rng(3)
    drawn = [draw_errors(rng, 0.05) for _ in range(4000)]
    tolerances = stated_tolerances(0.05)
    assert set(drawn[0]) == set(CONSTANTS) == set(tolerances)
    values = np.array([[one[key] for key in CONSTANTS] for one in drawn])
    for column, key in zip(values.T, CONSTANTS, strict=True):
        sd = 1e-4 if key == "transmission.lead" else 0.05
        assert abs(np.mean(column)) < 4.0 * sd / np.sqrt(4000)
        assert np.std(column) == pytest.approx(sd, rel=0.05)
        assert tolerances[key] == pytest.approx(2.0 * sd)
        assert np.mean(np.abs(column) < tolerances[key]) == pytest.approx(0.954, abs=0.015)
    others = np.corrcoef(values.T) - np.eye(len(CONSTANTS))
    assert np.max(np.abs(others)) < 0.08


def test_an_exact_sheet_is_stated_as_exact_and_drawn_so() -> None:
    """With no deviation the file says `exact`, and no constant moves."""
    assert stated_tolerances(0.0) == {"all": "exact"}
    assert set(draw_errors(np.random.default_rng(1), 0.0).values()) == {0.0}
    assert not any(half_widths(CONSTANTS, stated(DRIVE, 0.0).tolerances).values())


def test_faults_of_a_silent_sheet_are_clear_of_the_documented_tolerances() -> None:
    """A file that states no tolerances is handed out so, and a wrong inertia of its machine is 25 %
    off or more, a resistance 32 %: 2.5 of 10 % and of 13 %; healthy constants are off by 2 %."""
    setup = Setup(DRIVE, silent=True)
    for name, parameter, key, least in (
        ("load_inertia_error", "inertia_kg_m2", "load.inertia", 0.25),
        ("resistance_error", "resistance_ohm", "motor.resistance", 0.325),
    ):
        case = complete_case(Case(0, 22, "single", {name: {}}, sheet=0.02), setup)
        assert case.tolerances == {} == stated(setup, 0.02).tolerances
        off = {name: abs(case.constants[name] / value - 1.0) for name, value in CONSTANTS.items()}
        assert abs(case.effects[name][parameter] / CONSTANTS[key] - 1.0) == off[key] >= least
        del off[key]
        assert max(off.values()) < 0.08


def test_what_is_stated_is_a_drive_file() -> None:
    """The drive that a diagnosis is given survives being written and read as a drive file."""
    for sheet in (0.0, 0.02):
        drive = stated(DRIVE, sheet)
        again = drive_from_flat(drive_to_flat(drive), "again").tolerances
        widths = half_widths(CONSTANTS, again)
        assert widths == pytest.approx(half_widths(CONSTANTS, drive.tolerances))
        assert widths["load.inertia"] == pytest.approx(2.0 * sheet * 1.783e-3)


def test_every_uncertain_constant_of_the_machine_moves_by_its_error() -> None:
    """Nominal times one plus its error, constant by constant; gains and limits stay."""
    errors = {key: 0.01 * (1 + row) for row, key in enumerate(CONSTANTS)}
    machine = off_sheet(nominal_physics(DRIVE), errors)
    true = true_constants(machine, DRIVE)
    assert true.pop("controller.feed_scale") == 1.0
    for key, value in true.items():
        assert value == pytest.approx(CONSTANTS[key] * (1.0 + errors[key]), rel=1e-12), key
    plain = nominal_physics(DRIVE)
    for name in ("position_kp", "speed_kp", "speed_ki", "current_kp", "current_ki", "gear_ratio"):
        assert getattr(machine, name) == getattr(plain, name)


def test_half_of_the_controllers_know_the_true_lead() -> None:
    """The feed constant is off by the lead's error or not at all, and the rotor goes that way."""
    rng, errors = np.random.default_rng(4), {"transmission.lead": 0.01}
    drawn = [draw_feed(rng, errors)["controller.feed_scale"] for _ in range(2000)]
    assert set(drawn) == {0.0, 0.01} and np.mean(drawn) == pytest.approx(0.005, abs=5e-4)
    machine = off_sheet(nominal_physics(DRIVE), {"controller.feed_scale": 0.01})
    assert true_constants(machine, DRIVE)["controller.feed_scale"] == pytest.approx(1.01)
    assert machine.rod_per_rotor == nominal_physics(DRIVE).rod_per_rotor


def test_the_controller_believes_the_sheet() -> None:
    """Held at a rod position, the rotor stands where the sheet's lead puts it, and the rod is off
    by the error of the lead."""
    machine = off_sheet(nominal_physics(DRIVE), {"transmission.lead": 0.01})
    machine.half_backlash = 0.0
    plain = Nuisances(10, 0.0, 0.0, 0, 0)
    goal = 0.01
    held = np.full(20_000, goal), np.zeros(20_000)
    run = run_machine(machine, plain, DRIVE, held)
    per_rotor = 0.02 / (2.0 * np.pi * 2.16)
    angle = run.signals["rotor_position_rad"][-100:].mean()
    assert angle == pytest.approx(goal / per_rotor, rel=1e-4)
    assert run.signals["rod_position_m"][-100:].mean() == pytest.approx(1.01 * goal, rel=1e-4)


def test_a_fault_in_a_constant_leaves_the_sheet() -> None:
    """Draws within 2.5 tolerances go out to 2.5 to 6 on their side; others stay as drawn."""
    drive = stated(DRIVE, 0.05)  # tolerances of 10 %
    rng = np.random.default_rng(4)
    seen = []
    for share in (0.82, 0.95, 1.05, 1.18):
        for _ in range(50):
            values = {"torque_constant_nm_per_a": 0.716 * share}
            moved = leaving_the_sheet("torque_constant_error", values, drive, rng)
            off = moved["torque_constant_nm_per_a"] / 0.716 - 1.0
            assert np.sign(off) == np.sign(share - 1.0)
            assert 0.25 <= abs(off) <= 0.6
            seen.append(abs(off))
    assert np.ptp(seen) > 0.3
    far = {"resistance_ohm": 2.0 * 0.73}
    assert leaving_the_sheet("resistance_error", far, drive, rng) == far
    beyond = leaving_the_sheet("load_viscous_friction", {"viscous_nm_s_per_rad": 1e-3}, drive, rng)
    assert 2.5e-3 <= beyond["viscous_nm_s_per_rad"] <= 6e-3
    other = {"coulomb_nm": 1e-3}
    assert leaving_the_sheet("rotor_coulomb_friction", other, drive, rng) == other
    assert leaving_the_sheet("lead_error", {"lead_m": 0.02002}, stated(DRIVE, 0.0), rng) == {
        "lead_m": 0.02002
    }


def test_where_there_is_no_room_below_a_fault_goes_up() -> None:
    """A tolerance of half the constant leaves no physical value 2.5 of them below: it goes up."""
    drive = dataclasses.replace(DRIVE, tolerances={"motor.rotor_inertia": 0.5})
    moved = leaving_the_sheet(
        "rotor_inertia_error", {"inertia_kg_m2": 4e-4}, drive, np.random.default_rng(5)
    )
    assert 2.25 <= moved["inertia_kg_m2"] / 4.45e-4 <= 4.0


def test_a_faulty_constant_is_the_faults_value_and_the_others_stay_off() -> None:
    """In the label of a wrong resistance at 2 %, the resistance is the fault's; the rest lies off
    the sheet by more than nuisances do, and the machine that ran is that of the label."""
    case = complete_case(Case(0, 21, "single", {"resistance_error": {}}, sheet=0.02), DRIVE)
    true = case.effects["resistance_error"]["resistance_ohm"]
    assert case.constants["motor.resistance"] == true
    assert abs(true / 0.73 - 1.0) >= 0.1
    off = [abs(case.constants[key] / value - 1.0) for key, value in CONSTANTS.items()]
    assert np.median(off) > 5e-3
    assert case.tolerances["load.inertia"] == 0.04
    stage = Stage.of(case.seed, DRIVE, 0.02)
    machine = stage.with_effects(case.effects, case.seed)
    assert machine.load_inertia == case.constants["load.inertia"]
    assert machine.nominal_rod_per_rotor == DRIVE.transmission.rod_per_rotor
    assert stage.with_effects({}, case.seed).resistance != true
