"""Rigid drives of the sealed study: physics against closed forms, logs, what can be judged."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from ecyl_ros.errors import InputError
from ecyl_ros.gap.study.case import Case
from ecyl_ros.gap.study.drives import Choice, RigidDrives, draw_cases
from ecyl_ros.gap.study.rigid.cases import plan_cases, play, true_constants
from ecyl_ros.gap.study.rigid.demand import demand
from ecyl_ros.gap.study.rigid.drawn import draw_drive
from ecyl_ros.gap.study.rigid.equations import STEP_S, Truth, run
from ecyl_ros.gap.study.rigid.faults import FAULTS, clear, faults
from ecyl_ros.gap.study.rigid.judgeable import SHOWS, standing
from ecyl_ros.gap.study.rigid.structure import FORMS, LARGEST, SMALLEST, with_structure
from ecyl_ros.gap.study.seal import seal
from ecyl_ros.gap.study.subject import product_diagnosis

MACHINE = Truth(
    inertia=20.0,
    viscous=(30.0, 30.0),
    coulomb=(6.0, 6.0),
    presliding=1e-5,
    position_kp=0.0,
    speed_kp=2000.0,
    speed_ki=40_000.0,
    limit=1e9,
    control_steps=round(1e-3 / STEP_S),
)


def _held(truth: Truth, speed: float, seconds: float = 3.0) -> np.ndarray:
    """The last row of a run at a speed that the loop holds."""
    ticks = round(seconds * 1e3)
    zeros = np.zeros(ticks)
    return run(truth, zeros, np.full(ticks, speed), zeros, 0.0)[-1]


@pytest.mark.parametrize("speed", [-0.3, -0.01, 0.004, 0.02, 0.1])
def test_bristles_slide_at_the_steady_level(speed) -> None:
    """LuGre at constant speed: Coulomb plus what static friction has left at that speed, plus
    viscous friction, with the sign of the motion."""
    truth = MACHINE._replace(static=4.0, stribeck=0.02, bristle_ratio=0.4, bristle_fade=1e-3)
    level = 6.0 + 4.0 * math.exp(-((speed / 0.02) ** 2))
    wanted = math.copysign(level, speed) + 30.0 * speed
    row = _held(truth, speed)
    assert row[1] == pytest.approx(speed, rel=1e-6)
    assert row[2] == pytest.approx(wanted, rel=1e-4)


def test_below_its_level_friction_is_a_bent_bristle() -> None:
    """A force that rises slowly to below the level bends the bristles by -presliding
    ln(1 - force/level), and there the machine stays."""
    force, tiny = 3.0, 1e-6
    truth = MACHINE._replace(speed_kp=tiny, speed_ki=0.0, viscous=(0.0, 0.0), bristle_ratio=0.5)
    zeros = np.zeros(3000)
    rises = np.minimum(np.arange(3000) / 2000.0, 1.0)
    rows = run(truth, zeros, rises * force / tiny, zeros, 0.0)
    assert rows[-1, 3] == pytest.approx(-1e-5 * math.log(1.0 - force / 6.0), rel=5e-3)
    assert abs(rows[-1, 1]) < 1e-7


def test_voltage_balances_resistance_and_back_emf() -> None:
    """At constant speed u = R F / K + Ke v, the current F / K, with F the friction."""
    ohm, back_emf, constant, speed = 1.5, 12.0, 8.0, 0.2
    truth = MACHINE._replace(winding=(ohm, back_emf, 1e-3), gain=constant)
    row = _held(truth, speed)
    friction = 6.0 + 30.0 * speed
    assert row[5] == pytest.approx(friction / constant, rel=1e-4)
    assert row[2] == pytest.approx(ohm * friction / constant + back_emf * speed, rel=1e-4)


def test_a_winding_takes_its_time() -> None:
    """A step of voltage on a heavy machine: the current comes with L/R, here 4 ms."""
    truth = MACHINE._replace(
        inertia=1e9, winding=(2.0, 0.0, 4e-3), gain=1.0, speed_kp=1e-6, speed_ki=0.0
    )
    zeros = np.zeros(20)
    rows = run(truth, zeros, np.full(20, 1e6), zeros, 0.0)
    time = np.arange(20) * 1e-3
    np.testing.assert_allclose(rows[:, 5], 0.5 * (1.0 - np.exp(-time / 4e-3)), rtol=1e-6)


def test_the_drawn_machines_obey_their_equations() -> None:
    """Cogging, spring, disturbance, another axis and LuGre's bristles: scipy's RK45 goes the same
    way."""
    truth = MACHINE._replace(
        viscous=(30.0, 50.0),
        cogging=(4.0, 500.0, 0.7),
        sine=(3.0, 25.0, 0.2),
        constant=2.0,
        stiffness=300.0,
        presliding=2e-4,
        speed_kp=400.0,
        speed_ki=0.0,
    )
    ticks = 300
    wanted = 0.2 * np.sin(9.0 * np.arange(ticks) * 1e-3)
    other = 5.0 * np.cos(6.0 * np.arange(ticks) * 1e-3)
    rows = run(truth, np.zeros(ticks), wanted, np.zeros(ticks), 0.0, other)
    state, off, sigma = np.zeros(3), 0.0, 6.0 / 2e-4
    for tick in range(ticks):
        off = max(off, abs(state[0] - rows[tick, 3]))
        command = rows[tick, 2] - other[tick]

        def slope(t: float, s: np.ndarray, u: float = command) -> list[float]:
            q, v, z = s
            way = 0 if v >= 0.0 else 1
            load = 2.0 + 300.0 * q + 4.0 * np.sin(500.0 * q + 0.7) + 3.0 * np.sin(25.0 * t + 0.2)
            friction = (30.0, 50.0)[way] * v + sigma * z
            return [v, (u - load - friction) / 20.0, v - abs(v) * sigma * z / 6.0]

        span = (tick * 1e-3, (tick + 1) * 1e-3)
        state = solve_ivp(slope, span, state, "RK45", rtol=1e-6, atol=1e-9).y[:, -1]
    assert np.ptp(rows[:, 3]) > 0.005
    assert off < 2e-3 * np.ptp(rows[:, 3])


@pytest.mark.parametrize("linear", [True, False])
def test_the_closed_form_of_the_demand_is_what_the_machine_took(linear) -> None:
    """While a healthy drawn machine slides, the effort that acted is the demand along its motion,
    less the other axis', to a percent of its peak."""
    seed = next(
        seed
        for seed in range(40)
        if draw_drive(seed, linear, (), 0.05).facts["actuation"] in ("force", "torque")
    )
    case = Case(0, seed, "none", drives="rigid", sheet=0.05, facts={"linear": linear})
    ((drawn, truth, _, rows),) = play(case)
    speed, acceleration = rows[:, 1], rows[:, 4]
    time = np.arange(len(rows)) * 1e-3
    asked = demand(truth, time, rows[:, 3], speed, acceleration) + drawn.coupling
    slides = np.abs(speed) > 0.1 * np.max(np.abs(speed))
    # An acceleration is that of the step before the sample, under the command before it.
    gap = (asked[1:] - rows[:-1, 2])[slides[1:]]
    assert np.sqrt(np.mean(gap**2)) < 0.02 * np.max(np.abs(rows[:, 2]))


def test_drives_are_drawn_as_they_come() -> None:
    """Over 120 draws: every actuation, one-way and resting motion, lags within two samples, logs
    from 50 to 1000 Hz, noise up to the fault's size, steps of 8 to 16 bit or 1 to 50 um, values
    left out of the file."""
    drawn = [draw_drive(seed, bool(seed % 2), (), 0.05) for seed in range(120)]
    facts = [one.facts for one in drawn]
    assert {one["actuation"] for one in facts} == {"force", "torque", "current", "voltage", "loop"}
    for name in ("one_way", "rests", "moves", "coupled", "loop_known"):
        assert {one[name] for one in facts} == {True, False}
    assert {one["left_out"] for one in facts} == {None, "gain", "inertia"}
    rates = [one["logged_hz"] for one in facts]
    assert min(rates) == 50.0 and max(rates) == 1000.0
    assert max(abs(one["lag_samples"]) for one in facts) <= 2.0
    assert 0.5 < max(one["noise_over_fault"] for one in facts) <= 1.0
    assert any(one["frozen"] for one in facts)
    for one in drawn:
        if one.machine.actuation == "loop":
            assert (one.logger.rate_hz, one.logger.speed) == (1000.0, "missing")
            continue
        step = one.logger.resolution
        bits = math.log2(math.tau / step)
        assert 1e-6 <= step <= 5e-5 if one.machine.linear else bits == pytest.approx(round(bits))
    standing_still = [
        float(np.mean(np.abs(np.diff(one.reference)) < 1e-12))
        for one in drawn
        if one.facts["rests"]
    ]
    assert np.median(standing_still) > 0.45
    for one in drawn:
        if one.facts["one_way"]:
            assert np.all(np.diff(one.reference) >= -1e-12)


def test_machines_lie_off_their_file_as_its_tolerances_say() -> None:
    """Of inertia, gain, viscous and Coulomb friction 95 % lie within the tolerance of 10 % that
    is stated; a file that is exact is met exactly."""
    off = []
    for seed in range(100):
        one = draw_drive(seed, True, (), 0.05)
        stated = {
            "load.mass": one.machine.inertia,
            "actuation.gain": one.machine.gain,
            "load.viscous_friction": one.machine.viscous,
            "load.coulomb_friction": one.machine.coulomb,
        }
        assert set(one.tolerances.values()) == {0.1}
        off += [one.constants[key] / stated[key] - 1.0 for key in one.constants]
    assert np.std(off) == pytest.approx(0.05, rel=0.12)
    assert np.mean(np.abs(off) < 0.1) == pytest.approx(0.954, abs=0.035)
    exact = draw_drive(3, True, (), 0.0)
    assert exact.tolerances == {"all": "exact"}
    assert exact.constants["load.mass"] == pytest.approx(exact.machine.inertia, rel=1e-12)


def test_a_wrong_inertia_leaves_the_sheet() -> None:
    """With tolerances of 10 % the fault is 25 % or more, whatever is drawn."""
    drawn = draw_drive(3, True, ("load_inertia_error",), 0.05)
    for seed in range(30):
        fault = faults(True)["load_inertia_error"](
            drawn.truth, drawn.size, np.random.default_rng(seed)
        )
        assert fault.truth.inertia / drawn.truth.inertia >= 1.25


def test_faults_of_a_silent_sheet_are_clear_of_the_documented_tolerances() -> None:
    """A file that states no tolerances is handed out so; friction of a fault is 2.5 of 50 % of the
    sheet's or more, a mass 25 %, a load 25 % of the load that is stated."""
    stated = {
        "load_coulomb_friction": ("coulomb", 1.25),
        "load_viscous_friction": ("viscous", 1.25),
        "constant_load": ("constant", 0.25),
        "load_inertia_error": ("inertia", 0.25),
    }
    bound = set()
    for seed in range(30):
        for effect, (field, least) in stated.items():
            drawn = draw_drive(seed, True, (effect,), 0.02, silent=True)
            assert drawn.tolerances == {} and drawn.machine.tolerances == {}
            fault = faults(True)[effect](drawn.truth, drawn.size, np.random.default_rng(seed))
            more = np.abs(np.subtract(getattr(fault.truth, field), getattr(drawn.truth, field)))
            share = np.max(more) / (least * max(abs(getattr(drawn.machine, field)), 1e-12))
            assert share >= 0.9  # of an inertia, counted from the machine's own
            bound |= {effect} if share < 1.0 + 1e-9 else set()
    assert {"load_viscous_friction"} <= bound
    (case,) = draw_cases(RigidDrives(0.02, silent=True), 1, 5, Choice(kinds=("none",)))
    assert case.tolerances == {} == RigidDrives(0.02, silent=True).given(case).drive.tolerances


def test_a_constant_that_a_fault_comes_on_top_of_has_both_as_its_truth() -> None:
    """Friction on the file's friction is their sum; by direction, or drifting, it is none."""
    drawn = draw_drive(3, True, (), 0.05)

    def true_with(effect: str) -> dict[str, float]:
        fault = faults(True)[effect](drawn.truth, drawn.size, np.random.default_rng(2))
        return true_constants(drawn, fault.truth)

    key = "load.coulomb_friction"
    rubs = true_with("load_coulomb_friction")[key] - drawn.constants[key]
    assert rubs >= drawn.size.level > 0.0
    assert "load.viscous_friction" not in true_with("direction_dependent_friction")
    drifting = true_with("friction_drift")
    assert key not in drifting
    assert drifting["load.viscous_friction"] == drawn.constants["load.viscous_friction"]


def _stands(effect: str, *, one_way: bool, linear: bool = True, reach_share: float = 1.0) -> float:
    """How far a fault stands above noise on one drive that moves both ways, or forwards only."""
    drawn = next(
        one
        for one in (draw_drive(seed, linear, (), 0.05) for seed in range(200))
        if one.facts["one_way"] is one_way
        and one.facts["actuation"] in ("force", "torque")
        and one.facts["noise_over_fault"] < 0.1
        and not one.facts["coupled"]
    )
    fault = faults(linear)[effect](drawn.truth, drawn.size, np.random.default_rng(2))
    reference = drawn.reference * reach_share
    zeros = np.zeros(reference.size)
    rows = run(fault.truth, reference, zeros, drawn.noise, drawn.resolution, zeros)
    return standing(drawn, fault.truth, effect, rows)


def test_one_way_motion_hides_what_needs_both() -> None:
    """Forwards alone, Coulomb friction is a constant load and friction by direction friction;
    both ways they stand out. A spring does either way."""
    for effect in ("load_coulomb_friction", "constant_load", "direction_dependent_friction"):
        assert _stands(effect, one_way=True) < SHOWS
        assert _stands(effect, one_way=False) > SHOWS
    for one_way in (True, False):
        assert _stands("spring_load", one_way=one_way) > SHOWS


def test_cogging_needs_enough_of_a_turn() -> None:
    """Over all of the travel cogging stands out; over a hundredth of it there is no period."""
    whole, little = (
        _stands("cogging_torque", one_way=False, linear=False, reach_share=share)
        for share in (1.0, 0.003)
    )
    assert whole > SHOWS > little


def test_draws_hold_every_kind_and_repeat() -> None:
    """One seed, one hash; both outputs, every fault in turn; labels survive sealing."""
    planned = plan_cases(120, 5)
    assert {case.kind for case in planned} == {"single", "pair", "none", "withheld"}
    assert {name for case in planned for name in case.effects} == set(FAULTS)
    drives = RigidDrives()
    cases = draw_cases(drives, 6, 5)
    sealed = seal(cases)
    assert sealed.sha256 == seal(draw_cases(drives, 6, 5)).sha256
    assert sealed.sha256 != seal(draw_cases(drives, 6, 6)).sha256
    assert sealed.open() == cases
    one, again = drives.given(cases[0]).recording, drives.given(cases[0]).recording
    np.testing.assert_array_equal(one.stamp_ns, again.stamp_ns)
    named = "rod_position_m" if cases[0].facts["linear"] else "rotor_position_rad"
    np.testing.assert_array_equal(one.signal(named), again.signal(named))
    assert {case.sheet for case in plan_cases(40, 1)} == {0.0, 0.05}
    assert {case.sheet for case in plan_cases(5, 1, sheet=0.02)} == {0.02}


def test_structure_acts_beside_a_fault_as_large_as_its_label_says() -> None:
    """The effort that no model knows: its RMS over the fault's level, every form in some draw, the
    same again; the drive and its fault are those of the case without."""
    shapes = set()
    for seed in range(12):
        bare = draw_drive(seed, linear=True, effects=("load_coulomb_friction",), sheet=0.0)
        found, facts = with_structure(bare, seed)
        again, _ = with_structure(bare, seed)
        added = found.coupling - bare.coupling
        np.testing.assert_array_equal(added, again.coupling - bare.coupling)
        share = facts["structure_over_fault"]
        assert np.sqrt(np.mean(added**2)) == pytest.approx(share * bare.size.level)
        assert SMALLEST <= share <= LARGEST
        shapes.add(facts["structure"])
        assert found.truth == bare.truth and found.machine == bare.machine
    assert shapes == set(FORMS)
    (case,) = draw_cases(RigidDrives(), 1, 5, Choice(kinds=("structure",)))
    (played,) = play(case)
    assert case.kind == "structure" and len(case.effects) == 1
    assert case.facts["structure"] == played.drawn.facts["structure"]


def test_a_choice_that_leaves_nothing_is_refused() -> None:
    """A study of withheld cases without a fault that can be withheld says so in one line."""
    with pytest.raises(InputError, match="no case of kind single"):
        plan_cases(5, 1, kinds=("single",), effects=("spring_load",), without=("spring_load",))


def test_limiting_a_study_keeps_its_word() -> None:
    """Only the faults asked for; a name left out occurs in withheld cases alone."""
    choice = Choice(kinds=("single",), effects=("spring_load", "gravity_on_arm"))
    cases = RigidDrives().plan(20, 2, choice)
    assert {name for case in cases for name in case.effects} == set(choice.effects or ())
    alone = RigidDrives().plan(20, 2, Choice(effects=("spring_load",)))
    assert {case.kind for case in alone} == {"single", "none", "withheld"}
    barred = plan_cases(60, 3, without=("local_jam",))
    assert all("local_jam" in case.withheld for case in barred)
    held = {case.kind for case in barred if "local_jam" in case.effects}
    assert held == {"withheld"}


def test_the_diagnosis_gets_the_sheet_and_nothing_of_the_machine() -> None:
    """What is handed out is the file's values; the answer is a diagnosis of the contract."""
    drives = RigidDrives(0.05)
    case = draw_cases(drives, 1, 11, Choice(kinds=("single",), effects=("spring_load",)))[0]
    recording, sheet, _ = drives.given(case)
    drawn = draw_drive(case.seed, bool(case.facts["linear"]), ("spring_load",), 0.05)
    assert sheet == dataclasses.replace(drawn.machine, tolerances=drawn.tolerances)
    assert sheet.stiffness == 0.0
    said = product_diagnosis(recording, sheet, frozenset())
    assert said["schema"] == "ecyl.diagnosis/1"
    assert {"verdict", "causes", "location", "gap"} <= set(said)


def test_several_recordings_are_of_one_machine_moved_anew() -> None:
    """Three of 4 s of one drawn machine: the fault is the same, the motions are not, what swings
    begins in a phase of its own, and the same seed gives the same."""
    drives = RigidDrives(0.0, (3, 4.0))
    choice = Choice(kinds=("single",), effects=("periodic_disturbance",))
    (case,) = draw_cases(drives, 1, 5, choice)
    every = play(case)
    assert [len(one.rows) for one in every] == [4000] * 3
    assert len({one.truth._replace(sine=(0.0, 0.0, 0.0)) for one in every}) == 1
    assert len({one.truth.sine[:2] for one in every}) == 1
    assert len({one.truth.sine[2] for one in every}) == 3
    assert not np.allclose(every[0].drawn.reference, every[1].drawn.reference)
    recording, _, others = drives.given(case)
    again = drives.given(Case.from_label(case.label()))
    assert len(others) == 2 and recording.duration_s == pytest.approx(4.0, abs=0.1)
    for one, other in zip((recording, *others), (again.recording, *again.others), strict=True):
        for name in ("stamp_ns", "rod_position_m", "rotor_position_rad"):
            assert np.array_equal(getattr(one, name), getattr(other, name), equal_nan=True)


def test_a_pair_acts_as_both_do_and_never_of_what_looks_alike() -> None:
    """The effort of a machine with two faults is a healthy one's with what either adds by itself;
    all can be told apart."""
    drives = RigidDrives(0.0)
    cases = [drives.complete(one) for one in drives.plan(12, 4, Choice(kinds=("pair",)))]
    for case in cases:
        (played,) = play(case)
        first, second = case.effects
        assert clear(first, second) and set(played.alone) == set(case.effects)
        rows = played.rows
        time = np.arange(len(rows)) * 1e-3
        motion = time, rows[:, 3], rows[:, 1], rows[:, 4]
        if {"torque_ripple", "actuation_delay", "load_dependent_friction"} & set(case.effects):
            continue  # a share of the other, or as late
        healthy = demand(played.drawn.truth, *motion)
        added = sum(demand(one.truth, *motion) - healthy for one in played.alone.values())
        np.testing.assert_allclose(
            demand(played.truth, *motion), healthy + added, atol=1e-6 * played.drawn.size.level
        )


def test_a_machine_that_another_axis_pulls_at_is_not_called_healthy() -> None:
    """Of the drives without a fault, those with a pull that stands out of the noise are labelled
    as strange, all others as healthy."""
    drives = RigidDrives()
    plan = drives.plan(40, 3, Choice(kinds=("none",)))
    cases = [drives.complete(case) for case in plan]
    strange = [one for one in cases if one.kind == "outside"]
    assert strange and any(one.kind == "none" for one in cases)
    assert all(one.names <= {"x_other_axis", "x_winding_lag"} for one in strange)
    assert all(one.facts["coupled"] for one in strange if "x_other_axis" in one.names)
    assert not any(one.names for one in cases if one.kind == "none")


def test_what_comes_on_top_is_counted_from_the_file() -> None:
    """Friction of the label and of the drive file together are the machine's."""
    drives = RigidDrives(sheet=0.05)
    plan = drives.plan(8, 5, Choice(kinds=("single",), effects=("load_coulomb_friction",)))
    for planned in plan:
        (played,) = play(planned)
        (alone,) = played.alone.values()
        file, (value,) = played.drawn.machine.coulomb, alone.values.values()
        assert file + value * played.drawn.size.ratio == pytest.approx(played.truth.coulomb[0])
