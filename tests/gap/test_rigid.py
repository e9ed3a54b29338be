"""Rigid drives judged by effort, against machines whose effort is known in closed form."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from rigid_machines import LINEAR, ROTARY, motion, recorded
from scipy.signal import butter, sosfiltfilt

from ecyl_ros.drive.rigid.machine import KEYS, Machine
from ecyl_ros.drive.rigid.machine_file import load_machine
from ecyl_ros.effects import load_viscous_friction, spring_load
from ecyl_ros.errors import InputError
from ecyl_ros.gap.diagnose import diagnose
from ecyl_ros.gap.diagnosis import Measured
from ecyl_ros.gap.report.page import report_html
from ecyl_ros.gap.report.terminal import summary
from ecyl_ros.gap.rigid.balance import Balance
from ecyl_ros.gap.rigid.floor import repeatability
from ecyl_ros.gap.rigid.machine_values import told_apart
from ecyl_ros.gap.rigid.motion import motion_of
from ecyl_ros.gap.rigid.terms import Catalogue
from ecyl_ros.recording.signals import Recording

M = motion(0.1)
R = motion(1.5)
S, SR = np.sign(M.v), np.sign(R.v)


def _linear(extra, noise=0.3, seed=7, machine=LINEAR):
    return diagnose(recorded(M, 20.0 * M.a + extra, machine, noise, 1e-6, seed), machine)


def _values(result) -> dict[str, dict[str, float]]:
    return {one.effect: {p.name: p.value for p in one.parameters} for one in result.causes}


@pytest.mark.parametrize(
    ("extra", "effects"),
    [
        (9.0 * S, {"load_coulomb_friction": {"coulomb_n": 9.0}}),
        (40.0 * M.v, {"load_viscous_friction": {"viscous_n_s_per_m": 40.0}}),
        (8.0 + 0.0 * M.v, {"constant_load": {"force_n": 8.0}}),
        (120.0 * M.q, {"spring_load": {"stiffness_n_per_m": 120.0}}),
        (6.0 * M.a, {"load_inertia_error": {"mass_kg": 26.0}}),
        (
            np.where(M.v > 0, 13.0 + 35.0 * M.v, -6.5 + 55.0 * M.v),
            {
                "direction_dependent_friction": {
                    "coulomb_positive_n": 13.0,
                    "coulomb_negative_n": 6.5,
                    "viscous_positive_n_s_per_m": 35.0,
                    "viscous_negative_n_s_per_m": 55.0,
                }
            },
        ),
        (
            S * (7.0 + 8.0 * np.exp(-((M.v / 0.04) ** 2))),
            {"stribeck_friction": {"coulomb_n": 7.0, "static_n": 15.0}},
        ),
        (
            13.0 * S * (1.0 - 0.03 * M.t),
            {"friction_drift": {"coulomb_n": 13.0, "rate_per_s": -0.03}},
        ),
        (
            6.5 * np.sin(2.0 * np.pi * M.q / 0.01 + 1.0),
            {"cogging_torque": {"amplitude_n": 6.5, "period_m": 0.01}},
        ),
        (
            6.5 * np.sin(2.0 * np.pi * 7.3 * M.t + 0.4),
            {"periodic_disturbance": {"amplitude_n": 6.5, "frequency_hz": 7.3}},
        ),
        (
            9.0 * S * (np.abs(M.q - 0.05) < 0.02),
            {"local_jam": {"position_m": 0.05, "width_m": 0.04}},
        ),
    ],
    ids=lambda one: next(iter(one)) if isinstance(one, dict) else "",
)
def test_each_effect_is_named_alone_and_sized(extra, effects) -> None:
    """One fault: it and no other is named, with the parameters it was made with."""
    result = _linear(extra)
    found = _values(result)
    assert set(found) == set(effects)
    for effect, parameters in effects.items():
        loose = 0.25 if effect in ("stribeck_friction", "local_jam") else 0.02
        for name, value in parameters.items():
            assert found[effect][name] == pytest.approx(value, rel=loose)
    assert result.verdict in ("explained", "partly_explained") and result.shrink > 0.8
    assert result.after < result.before


def test_a_machine_as_modelled_has_no_gap() -> None:
    """Without a fault nothing is named, linear and rotary, whatever the noise's seed."""
    for seed in range(4):
        assert _linear(0.0, seed=seed).verdict == "no_gap"
        rotary = diagnose(recorded(R, 0.02 * R.a, ROTARY, 0.005, 1e-4, seed), ROTARY)
        assert rotary.verdict == "no_gap" and not rotary.causes


def test_two_effects_are_both_named() -> None:
    """Friction with cogging, and friction with a load: each with both sizes."""
    both = _values(_linear(9.0 * S + 6.5 * np.sin(2.0 * np.pi * M.q / 0.01)))
    assert both["load_coulomb_friction"]["coulomb_n"] == pytest.approx(9.0, rel=0.02)
    assert both["cogging_torque"]["period_m"] == pytest.approx(0.01, rel=1e-3)
    load = _values(_linear(9.0 * S + 4.0))
    assert load["load_coulomb_friction"]["coulomb_n"] == pytest.approx(9.0, rel=0.02)
    assert load["constant_load"]["force_n"] == pytest.approx(4.0, rel=0.02)


def test_cogging_and_ripple_of_a_rotor_are_told_apart() -> None:
    """A torque of the angle is cogging, a share of the motor's is ripple; orders are exact."""
    turning = motion(12.0, duration_s=20.0)
    effort = 0.02 * turning.a + 0.05 * np.sin(12.0 * turning.q + 1.0)
    result = diagnose(recorded(turning, effort, ROTARY, 0.01, 1e-4), ROTARY)
    assert _values(result)["cogging_torque"]["periods_per_rev"] == 12.0
    assert _values(result)["cogging_torque"]["amplitude_nm"] == pytest.approx(0.05, rel=0.03)
    effort = 0.02 * turning.a / (1.0 + 0.2 * np.sin(12.0 * turning.q))
    result = diagnose(recorded(turning, effort, ROTARY, 0.01, 1e-4), ROTARY)
    assert [one.effect for one in result.causes] == ["torque_ripple"]
    assert _values(result)["torque_ripple"]["fraction"] == pytest.approx(0.2, rel=0.05)


def test_a_disturbance_outside_the_catalogue_is_not_named() -> None:
    """A force that wanders by itself: a gap, and no cause."""
    sos = butter(2, (0.3, 6.0), btype="bandpass", fs=1000.0, output="sos")
    for seed in (1, 2, 3, 4):
        wander = sosfiltfilt(sos, np.random.default_rng(seed).normal(size=M.t.size))
        result = _linear(6.0 * wander / np.std(wander))
        assert result.verdict == "unexplained" and not result.causes
        assert any("does not repeat with the motion" in note for note in result.notes)


def test_a_late_actuator_shows_as_a_delay() -> None:
    """Effort 8 ms ahead of the motion is a delay of 8 ms, of the actuator or of the measurement."""
    effort = np.interp(M.t + 0.008, M.t, 20.0 * M.a + 9.0 * S)
    result = diagnose(recorded(M, effort, LINEAR, 0.3, 1e-6), LINEAR)
    found = {one.effect: one for one in result.causes}
    assert set(found) == {"load_coulomb_friction", "actuation_delay"}
    assert _values(result)["actuation_delay"]["delay_s"] == pytest.approx(0.008, rel=0.03)
    assert found["actuation_delay"].alternatives == ("measurement_delay",)


def test_what_the_file_leaves_out_is_found_and_said() -> None:
    """Without mass: found within 1 %, a note says so. Without gain: multiples of the ampere."""
    machine = dataclasses.replace(LINEAR, inertia=None)
    result = _linear(9.0 * S, machine=machine)
    mass = next(one for one in result.measured if one.name == "mass_kg")
    assert mass.value == pytest.approx(20.0, rel=0.01) and mass.low < 20.0 < mass.high
    assert mass.nominal is None and "load.mass is left out" in result.notes[0]
    ampere = Machine(kind="rigid", output="rotary", actuation="current")
    result = diagnose(recorded(R, 0.02 * R.a + 0.1 * SR, ampere, 0.004, 1e-4), ampere)
    assert result.signals[0].unit == "A"
    assert _values(result) == {
        "rotor_coulomb_friction": {"coulomb_a": pytest.approx(0.1, rel=0.02)}
    }
    assert any("actuation.gain is left out" in note for note in result.notes)


@pytest.mark.parametrize(("high", "said"), [(-0.9, True), (0.9, False)])
def test_a_friction_below_zero_is_said_to_be_none(high: float, said: bool) -> None:
    """A measured friction whose whole interval is negative says that the model lacks something."""
    recording = recorded(M, 20.0 * M.a, LINEAR, 0.3, 1e-6)
    along = Catalogue(motion_of(recording, LINEAR, "r"), LINEAR).along
    found = Measured(
        "viscous_n_s_per_m", "N s/m", -5.0, -10.0, high, "friction in proportion to speed", None
    )
    told = told_apart(load_viscous_friction.term(along), found, (), (), (), along, gain=False)
    assert ("negative, as no friction is" in told.meaning) == said


def test_intervals_hold_under_correlated_disturbance() -> None:
    """95 % intervals of a level cover it at least 10 times in 12 although what is left is red."""
    covered = 0
    for seed in range(12):
        rng = np.random.default_rng(100 + seed)
        red = np.zeros(M.t.size)
        white = rng.normal(size=M.t.size) * 0.2
        for index in range(1, red.size):
            red[index] = 0.99 * red[index - 1] + white[index]
        result = _linear(9.0 * S + red, seed=seed)
        one = next(c for c in result.causes if c.effect == "load_coulomb_friction")
        covered += one.parameters[0].low <= 9.0 <= one.parameters[0].high
    assert covered >= 10


def test_the_floor_is_what_does_not_repeat() -> None:
    """On a motion that comes again, the floor is the noise that was put in, within a quarter."""
    m = motion(0.1, duration_s=40.0)
    w = 2.0 * np.pi * 0.5
    cycle = dataclasses.replace(
        m, q=0.1 * np.sin(w * m.t), v=0.1 * w * np.cos(w * m.t), a=-0.1 * w**2 * np.sin(w * m.t)
    )
    machine = dataclasses.replace(LINEAR, bandwidth_hz=25.0)
    unknown = 5.0 * np.sin(80.0 * cycle.q) ** 3 * cycle.v / 0.3  # repeats, and is in no catalogue
    recording = recorded(cycle, 20.0 * cycle.a + unknown, machine, 1.0, 1e-6)
    moved = motion_of(recording, machine, "r")
    catalogue = Catalogue(moved, machine)
    balance = Balance(moved, catalogue.nominal(), catalogue.model)
    found = repeatability(
        balance,
        balance.fit([one.term(catalogue.along) for one in (load_viscous_friction, spring_load)]),
        False,
    )
    # White noise of 1 N up to 25 Hz of 500, through a fourth-order filter run both ways.
    assert found == pytest.approx(np.sqrt(25.0 / 500.0) * 0.96, rel=0.25)


def test_one_mode_is_judged_by_itself() -> None:
    """Friction in the second half only: named there, no gap in the first, none lost by name."""
    mode = (M.t > 10.0).astype(float)
    recording = recorded(M, 20.0 * M.a + 9.0 * S * mode, LINEAR, 0.3, 1e-6, mode=mode)
    assert diagnose(recording, LINEAR, mode=0.0).verdict == "no_gap"
    second = diagnose(recording, LINEAR, mode=1.0)
    assert [one.effect for one in second.causes] == ["load_coulomb_friction"]
    together = diagnose(recording, LINEAR)
    assert any("mode changes within the run (0, 1)" in note for note in together.notes)
    share = {one.condition: one.share for one in together.when}
    assert share["mode_1"] > 0.95
    with pytest.raises(InputError, match=r"mode 7 does not occur; modes recorded: 0, 1"):
        diagnose(recording, LINEAR, mode=7.0)


def test_a_known_loop_is_checked_against_the_recorded_effort() -> None:
    """The controller's port stands at its floor with the true gain, above it with a wrong one."""
    reference = motion(0.1)
    speed = np.zeros_like(reference.q)
    q = np.round(0.98 * reference.q / 1e-7) * 1e-7
    speed[2:] = 0.5 * RATE * (q[2:] - q[:-2])
    command = 50.0 * (20.0 * (reference.q - q) - speed)
    recording = Recording(
        stamp_ns=np.round(reference.t * 1e9).astype(np.int64),
        reference_position_m=reference.q,
        rod_position_m=q,
        voltage_q_v=command,
    )
    for gain, alike in ((20.0, True), (24.0, False)):
        machine = Machine(
            kind="rigid",
            output="linear",
            actuation="voltage",
            gain=2.0,
            position_kp=gain,
            speed_kp=50.0,
        )
        ports = {one.block: one.ratio for one in diagnose(recording, machine).ports}
        assert (ports["controller"] < 1.5) == alike


RATE = 1000.0


def test_reports_are_made_of_a_rigid_drive() -> None:
    """Page and summary name cause, measured values and what the floor is, in the drive's units."""
    machine = dataclasses.replace(LINEAR, inertia=None)
    result = _linear(np.where(M.v > 0, 13.0 + 35.0 * M.v, -6.5 + 55.0 * M.v), machine=machine)
    text, page = summary(result), report_html(result)
    assert "Coulomb level forwards" in text and "N s/m" in text and "mass" in text
    assert "The machine as measured" in page and result.floor_is in page
    assert "position / " in page and "nan" not in page.lower().replace("nano", "")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"rod_force_n": None}, r"no effort \(force\) recorded"),
        ({"rod_position_m": None}, r"rod_position in m is missing"),
        ({"rod_position_m": np.zeros(M.t.size)}, r"does not move by more than 20 times its noise"),
        ({"rod_force_n": np.zeros(M.t.size)}, r"the effort never changes"),
    ],
)
def test_unusable_recordings_are_refused_by_name(change, message) -> None:
    """No effort, no position, no motion, a dead effort: one line that says which."""
    good = recorded(M, 20.0 * M.a, LINEAR, 0.3, 1e-6)
    signals = {"rod_position_m": good.rod_position_m, "rod_force_n": good.rod_force_n} | change
    bad = Recording(stamp_ns=good.stamp_ns, **{k: v for k, v in signals.items() if v is not None})
    with pytest.raises(InputError, match=message) as caught:
        diagnose(bad, LINEAR, source="x.mcap")
    assert str(caught.value).startswith("x.mcap: ") and "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("signal", "note"),
    [
        (
            "rotor_velocity_rad_per_s",
            "rotor_velocity in rad/s is not used: the velocity of a linear output is "
            "rod_velocity in m/s",
        ),
        ("rod_velocity_m_per_s", None),
    ],
)
def test_a_speed_of_the_other_kind_is_told(signal: str, note: str | None) -> None:
    """A map that gives a linear drive an angular speed loses it with a line, not in silence."""
    good = recorded(M, 20.0 * M.a, LINEAR, 0.3, 1e-6)
    given = motion_of(dataclasses.replace(good, **{signal: M.v}), LINEAR, "x.mcap")
    assert [one for one in given.notes if "not used" in one] == ([note] if note else [])


def test_a_short_recording_is_refused() -> None:
    """Less than 3 s: refused with the length."""
    short = recorded(M, 20.0 * M.a, LINEAR, 0.3, 1e-6).slice(0.0, 2.0)
    with pytest.raises(InputError, match=r"2 s long, expected at least 3 s"):
        diagnose(short, LINEAR)


FILE = "/**:\n  ros__parameters:\n"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("    drive: {kind: rigid}\n", "drive.output is missing; expected linear or rotary"),
        ("    drive: {kind: stiff, output: linear}\n", "drive.kind = 'stiff', expected rigid"),
        (
            "    drive: {kind: rigid, output: linear}\n    load: {mas: 3.0}\n",
            "unknown key load.mas; did you mean load.mass",
        ),
        (
            "    drive: {kind: rigid, output: rotary}\n    load: {mass: 3.0}\n",
            "load.mass does not go with drive.output rotary; expected load.inertia",
        ),
        (
            "    drive: {kind: rigid, output: linear}\n    load: {mass: -3.0}\n",
            "load.mass = -3, expected a number from 1e-06 to 1e+06 kg",
        ),
        (
            "    drive: {kind: rigid, output: linear}\n    actuation: {signal: loop}\n",
            "controller.speed.kp is missing",
        ),
        (
            "    drive: {kind: rigid, output: linear}\n    load: {mass: heavy}\n",
            "load.mass = 'heavy', expected a number",
        ),
    ],
)
def test_drive_files_are_checked_by_name(tmp_path, text, message) -> None:
    """A key or value that is wrong is named, with what was expected."""
    path = tmp_path / "d.yaml"
    path.write_text(FILE + text)
    with pytest.raises(InputError) as caught:
        load_machine(path)
    assert message in str(caught.value) and str(path) in str(caught.value)


def test_every_key_of_a_drive_file_reaches_the_machine(tmp_path) -> None:
    """A file with all keys of a linear drive gives a machine with all of their values."""
    lines = ["    drive.kind: rigid\n", "    drive.output: linear\n"]
    expected = {}
    for number, (name, key) in enumerate(KEYS.items()):
        if key.choices or "linear" not in key.outputs:
            continue
        value = 0.1 + 0.01 * number if key.high < 10.0 else 2.0 + number
        value = min(value, key.high)
        lines.append(f"    {name}: {value}\n")
        expected[key.field] = pytest.approx(value)
    path = tmp_path / "d.yaml"
    path.write_text(FILE + "".join(lines))
    machine = load_machine(path)
    assert {name: getattr(machine, name) for name in expected} == expected
