"""The file that a diagnosis of a rigid drive writes: read back, it leaves no gap."""

from __future__ import annotations

import dataclasses
import re
from pathlib import Path

import numpy as np
import pytest
from rigid_machines import LINEAR, ROTARY, motion, recorded

from ecyl_ros.cli.main import main
from ecyl_ros.drive.rigid.effects_file import effects_table
from ecyl_ros.drive.rigid.machine import Machine
from ecyl_ros.drive.rigid.machine_file import load_machine
from ecyl_ros.effects.catalogue import RIGID
from ecyl_ros.errors import InputError
from ecyl_ros.gap.diagnose import diagnose
from ecyl_ros.gap.twin.closer import write_twin
from ecyl_ros.recording.csvfile import write_csv

HEAD = "# My drive.\n/**:\n  ros__parameters:\n    drive: {kind: rigid, output: %s}\n"
M, R, TURNS = motion(0.1), motion(1.5), motion(12.0)
S, SR = np.sign(M.v), np.sign(R.v)
DOWN = np.where(M.v > 0, 13.0 + 35.0 * M.v, -6.5 + 55.0 * M.v)

LINEAR_FAULTS = {
    "viscous": 40.0 * M.v,
    "coulomb": 9.0 * S,
    "constant": 8.0 + 0.0 * M.v,
    "spring": 120.0 * (M.q - 0.03),
    "inertia": 6.0 * M.a,
    "direction": DOWN,
    "stribeck": S * (7.0 + 8.0 * np.exp(-((M.v / 0.04) ** 2))),
    "drift": 13.0 * S * (1.0 - 0.03 * M.t),
    "cogging": 6.5 * np.sin(2.0 * np.pi * M.q / 0.01 + 1.0),
    "two orders": 6.5 * np.sin(2.0 * np.pi * M.q / 0.01 + 1.0) + 3.0 * np.sin(1500.0 * M.q),
    "disturbance": 6.5 * np.sin(2.0 * np.pi * 7.3 * M.t + 0.4),
    "friction and load": 9.0 * S - 4.0,
    "friction and cogging": DOWN + 5.0 * np.sin(2.0 * np.pi * M.q / 0.01 + 1.0),
}


def _file(path: Path, body: str, output: str = "linear") -> Path:
    path.write_text(HEAD % output + body, encoding="utf-8")
    return path


def _twin(tmp_path: Path, recording, body: str, output: str = "linear"):
    """First diagnosis, the twin's file, and the diagnosis by it."""
    nominal = _file(tmp_path / "nominal.yaml", body, output)
    first = diagnose(recording, load_machine(nominal))
    write_twin(first, nominal, tmp_path / "twin.yaml")
    return first, diagnose(recording, load_machine(tmp_path / "twin.yaml"))


@pytest.mark.parametrize("fault", LINEAR_FAULTS)
def test_a_twin_of_a_linear_drive_leaves_no_gap(tmp_path, fault) -> None:
    """Every effect that acts on a straight output: written, read, and the gap is gone."""
    recording = recorded(M, 20.0 * M.a + LINEAR_FAULTS[fault], LINEAR, 0.3, 1e-6)
    body = "    actuation: {signal: force}\n    load: {mass: 20.0}  # kg\n"
    first, second = _twin(tmp_path, recording, body)
    assert first.causes and not second.causes
    if fault == "stribeck":  # its speed is known to a step of the search
        assert second.signals[0].gap < 0.06 * first.signals[0].gap
    else:
        assert second.verdict == "no_gap", second.signals[0]
    text = (tmp_path / "twin.yaml").read_text(encoding="utf-8")
    mass = re.search(r"mass: ([0-9.]+)", text)
    assert mass is not None
    assert fault == "inertia" or float(mass[1]) == pytest.approx(20.0, rel=5e-3)
    as_before = text.replace(mass[0], "mass: 20.0", 1)
    assert as_before.startswith(HEAD % "linear" + body.rstrip("\n"))


def test_a_twin_of_a_sound_machine_has_its_constants(tmp_path) -> None:
    """Within the sheet: the mass that was found takes the nominal one's place; no gap is left."""
    recording = recorded(M, 21.0 * M.a + 9.0 * S, LINEAR, 0.3, 1e-6)
    body = "    actuation: {signal: force}\n    load: {mass: 20.0, coulomb_friction: 9.0}\n"
    first, second = _twin(tmp_path, recording, body)
    assert first.verdict == "within_sheet" and second.verdict == "no_gap"
    assert load_machine(tmp_path / "twin.yaml").inertia == pytest.approx(21.0, rel=5e-3)


@pytest.mark.parametrize(
    ("extra", "effect"),
    [
        (0.05 * np.sin(12.0 * TURNS.q + 1.0), "cogging_torque"),
        (-0.2 * np.sin(12.0 * TURNS.q) / (1.0 + 0.2 * np.sin(12.0 * TURNS.q)), "torque_ripple"),
    ],
)
def test_a_twin_of_a_rotor_cogs_and_ripples(tmp_path, extra, effect) -> None:
    """A torque of the angle, and a share of the motor's own, with phase and order."""
    torque = 0.02 * TURNS.a * (1.0 + extra) if effect == "torque_ripple" else 0.02 * TURNS.a + extra
    recording = recorded(TURNS, torque, ROTARY, 0.01, 1e-4)
    body = "    actuation: {signal: torque}\n    load: {inertia: 0.02}\n"
    first, second = _twin(tmp_path, recording, body, "rotary")
    assert [one.effect for one in first.causes] == [effect]
    assert second.verdict == "no_gap" and not second.causes


def test_what_the_file_left_out_is_written_too(tmp_path) -> None:
    """A mass goes into its own key; without a gain, inertia and friction go by the ampere."""
    recording = recorded(M, 20.0 * M.a + 9.0 * S, LINEAR, 0.3, 1e-6)
    _, second = _twin(tmp_path, recording, "    actuation: {signal: force}\n")
    assert second.verdict == "no_gap"
    assert load_machine(tmp_path / "twin.yaml").inertia == pytest.approx(20.0, rel=0.01)
    ampere = Machine(kind="rigid", output="rotary", actuation="current")
    recording = recorded(R, 0.02 * R.a + 0.1 * SR, ampere, 0.004, 1e-4)
    _, second = _twin(tmp_path, recording, "    actuation: {signal: current}\n", "rotary")
    assert second.verdict == "no_gap"
    assert "coulomb_a" in (tmp_path / "twin.yaml").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("sheet", "tolerance"),
    [("{actuation: {gain: 20 %}}", True), ("10 %", False)],
)
def test_a_twin_holds_what_differs_and_how_well_it_is_known(
    tmp_path, sheet: str, tolerance: bool
) -> None:
    """An inertia left out is found and written with a tolerance that holds its 95 % interval, where
    there is room for one; a gain that the recording says nothing of stays as it was."""
    effort = (0.02 * R.a + 0.3 * SR + 0.04 * R.v) / 2.0
    machine = dataclasses.replace(ROTARY, actuation="current")
    body = f"    actuation: {{signal: current, gain: 2.0}}\n    tolerances: {sheet}\n"
    first, second = _twin(tmp_path, recorded(R, effort, machine, 0.01, 1e-6), body, "rotary")
    assert first.causes and not second.causes
    text = (tmp_path / "twin.yaml").read_text(encoding="utf-8")
    twin = load_machine(tmp_path / "twin.yaml")
    assert "torque_constant" not in text and "    load: {inertia: 0.0" in text
    measured = {one.name: one for one in first.measured}
    inertia = measured["inertia_kg_m2"]
    assert inertia.low < 0.02 < inertia.high
    assert ("load.inertia" in twin.tolerances) is tolerance
    if tolerance:
        assert twin.inertia * (1.0 + twin.tolerances["load.inertia"]) >= inertia.high
    # One value and one interval of each quantity, as uncertain as the scale of all torques.
    share = 0.2 if "gain" in sheet else 0.1
    for cause in first.causes:
        for one in cause.parameters:
            again = measured[one.name]
            assert (again.value, again.low, again.high) == (one.value, one.low, one.high)
            assert one.high - one.low >= 2.0 * share * one.value
    assert inertia.high - inertia.low >= 2.0 * share * inertia.value


def test_a_twin_of_a_twin_adds_up(tmp_path) -> None:
    """More friction beyond that of a twin's file: one effect with the sum of both."""
    body = "    actuation: {signal: force}\n    load: {mass: 20.0}\n"
    first = recorded(M, 20.0 * M.a + 9.0 * S, LINEAR, 0.3, 1e-6)
    _twin(tmp_path, first, body)
    worse = recorded(M, 20.0 * M.a + 15.0 * S, LINEAR, 0.3, 1e-6)
    found = diagnose(worse, load_machine(tmp_path / "twin.yaml"))
    write_twin(found, tmp_path / "twin.yaml", tmp_path / "again.yaml")
    (effect,) = load_machine(tmp_path / "again.yaml").effects
    assert effect.name == "load_coulomb_friction"
    assert effect.values["coulomb"] == pytest.approx(15.0, rel=0.02)
    assert diagnose(worse, load_machine(tmp_path / "again.yaml")).verdict == "no_gap"


def test_the_command_writes_the_twin_and_takes_it(tmp_path, capsys) -> None:
    """`ecyl diagnose --write-drive` on a CSV, then `--drive` of what it wrote: no gap."""
    recording = recorded(M, 20.0 * M.a + DOWN, LINEAR, 0.3, 1e-6)
    write_csv(recording, tmp_path / "run.csv")
    nominal = _file(tmp_path / "n.yaml", "    actuation: {signal: force}\n    load: {mass: 20.0}\n")
    run = ["diagnose", str(tmp_path / "run.csv"), "--drive"]
    assert main([*run, str(nominal), "--write-drive", str(tmp_path / "t.yaml")]) == 0
    assert str(tmp_path / "t.yaml") in capsys.readouterr().out
    assert main([*run, str(tmp_path / "t.yaml")]) == 0
    assert "There is no gap to explain" in capsys.readouterr().out


def test_no_cause_no_file(tmp_path) -> None:
    """A machine as modelled: nothing to write, and nothing written."""
    nominal = _file(tmp_path / "n.yaml", "    actuation: {signal: force}\n    load: {mass: 20.0}\n")
    result = diagnose(recorded(M, 20.0 * M.a, LINEAR, 0.3, 1e-6), load_machine(nominal))
    with pytest.raises(InputError, match="no cause was named"):
        write_twin(result, nominal, tmp_path / "t.yaml")
    assert not (tmp_path / "t.yaml").exists()


@pytest.mark.parametrize(
    ("effects", "message"),
    [
        ("{load_coulom_friction: {coulomb_n: 3.0}}", "did you mean load_coulomb_friction?"),
        ("{load_coulomb_friction: {coulomb_nm: 3.0, coulomb_n: 3.0}}", "counted in one unit"),
        ("{load_coulomb_friction: {level: 3.0}}", "effects.load_coulomb_friction.level; expected"),
        ("{load_coulomb_friction: {coulomb_n: big}}", "coulomb_n = 'big', expected a number"),
        ("{stribeck_friction: {coulomb_n: 3.0}}", "effects.stribeck_friction.static_n is missing"),
        ("{cogging_torque: {amplitude_n: -1.0, period_m: 0.1}}", "amplitude_n = -1, expected"),
        (
            "{cogging_torque: {amplitude_n: 1.0, periods_per_screw_rev: 3.0}}",
            "screw.lead is missing",
        ),
        (
            "{cogging_torque: {amplitude_n: 1.0}}",
            "periods_per_screw_rev or period_m is missing",
        ),
        (
            "{torque_constant_error: {torque_constant_n_per_a: 1.0, torque_constant_n_per_v: 1.0}}",
            "expected one of",
        ),
    ],
)
def test_effects_of_a_file_are_checked_by_name(tmp_path, effects, message) -> None:
    """An effect, parameter or value that is wrong is named, with what was expected."""
    path = _file(tmp_path / "d.yaml", f"    load: {{mass: 2.0}}\n    effects: {effects}\n")
    with pytest.raises(InputError) as caught:
        load_machine(path)
    assert message in str(caught.value) and str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_effects_in_another_unit_than_the_recording_are_refused(tmp_path) -> None:
    """Friction in ampere does not go with an effort in newton."""
    path = _file(tmp_path / "d.yaml", "    effects: {load_coulomb_friction: {coulomb_a: 0.1}}\n")
    machine = dataclasses.replace(load_machine(path), actuation="force", gain=1.0, inertia=20.0)
    with pytest.raises(InputError, match=r"effort comes in N, the effects .* counted in A"):
        diagnose(recorded(M, 20.0 * M.a, LINEAR, 0.3, 1e-6), machine)


def test_the_page_has_the_table_of_effects() -> None:
    """docs/drive-file.md holds what the code prints, for every effect of either output."""
    page = Path(__file__).parents[2] / "docs" / "drive-file.md"
    assert effects_table() in page.read_text(encoding="utf-8")
    assert all(f"`{name}`" in effects_table() for name in RIGID)


def test_constants_within_their_tolerance_go_into_the_twin(tmp_path) -> None:
    """Cogging on a machine 5 % above its sheet: keys, sheet and replay follow."""
    drag = 20.0 * M.a + 42.0 * M.v + 4.3 * S
    recording = recorded(
        M, 1.05 * drag + 12.0 * np.sin(2.0 * np.pi * M.q / 0.01), LINEAR, 0.3, 1e-6
    )
    body = (
        "    actuation: {signal: force}\n"
        "    load: {mass: 20.0, viscous_friction: 42.0, coulomb_friction: 4.3}\n"
        "    tolerances: {load.mass: 0.1, load.viscous_friction: 0.2, load.coulomb_friction: 0.2}\n"
    )
    first, second = _twin(tmp_path, recording, body)
    assert [one.effect for one in first.causes] == ["cogging_torque"]
    found = {one.parameter: one for one in first.sheet}
    twin = load_machine(tmp_path / "twin.yaml")
    for key, true, written in (
        ("load.mass", 21.0, twin.inertia),
        ("load.viscous_friction", 44.1, twin.viscous),
        ("load.coulomb_friction", 4.515, twin.coulomb),
    ):
        assert written == pytest.approx(true, rel=0.01)
        assert found[key].value == pytest.approx(written)
        assert found[key].low <= true <= found[key].high
    assert [one.name for one in twin.effects] == ["cogging_torque"]
    assert second.verdict == "no_gap"
    assert first.after < 1.15 * first.floor


def test_a_constant_load_is_no_spring_a_long_way_off(tmp_path) -> None:
    """A load of 250 N that rises by 1 N over the travel is a constant load; what rises is found by
    the twin, as a spring of its true stiffness."""
    effort = 20.0 * M.a + 250.0 + 3.0 * M.q
    body = "    actuation: {signal: force, gain: 1.0}\n    load: {mass: 20.0}\n"
    first, again = _twin(tmp_path, recorded(M, effort, LINEAR, 0.1, 1e-6), body)
    assert [one.effect for one in first.causes] == ["constant_load"]
    assert first.causes[0].parameters[0].value == pytest.approx(250.0, rel=0.01)
    assert [one.effect for one in again.causes] == ["spring_load"]
    assert again.causes[0].parameters[0].value == pytest.approx(3.0, rel=0.05)


def test_a_mass_that_was_not_seen_is_not_written(tmp_path) -> None:
    """A recording that says the machine weighs nothing: its twin leaves the mass out, as before."""
    effort = 30.0 * S - 0.5 * M.a
    body = "    actuation: {signal: force, gain: 1.0}\n"
    first, _ = _twin(tmp_path, recorded(M, effort, LINEAR, 0.1, 1e-6), body)
    assert first.closest is not None and first.closest.inertia is not None
    assert first.closest.inertia < 1e-6
    assert load_machine(tmp_path / "twin.yaml").inertia is None
