"""Drives in other simulators: MJCF run in MuJoCo beside the engine, URDF, SDF, and back."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

import ecyl_ros as ec
from ecyl_ros.cli.main import main
from ecyl_ros.drive.model_file import load_model
from ecyl_ros.drive.rigid.machine_file import machine_from_flat
from ecyl_ros.export.joint_values import parameters, read_joint
from ecyl_ros.export.mechanism import Mechanism, of
from ecyl_ros.export.mjcf import mjcf
from ecyl_ros.export.sdf import sdf
from ecyl_ros.export.urdf import urdf

MOVES = "moves:positions=0.004;-0.002;0.001,speed=0.05,acceleration=1,jerk=50,dwell=0.2"
NOISE = ("rotor_position", "rotor_velocity", "current", "rod_position")
QUIET = {f"sensors.{name}_noise": 0.0 for name in NOISE} | {
    "sensors.rotor_position_resolution": 0.0,
    "sensors.rod_position_resolution": 0.0,
}
# A worn drive whose faults joints have words for.
WORN = {
    "transmission.backlash": 2.7e-3,
    "effects.load_coulomb_friction.coulomb_nm": 0.08,
    "effects.rotor_viscous_friction.viscous_nm_s_per_rad": 4e-3,
    "effects.constant_load.force_n": 150.0,
    "effects.spring_load.stiffness_n_per_m": 2e4,
    "effects.load_inertia_error.inertia_kg_m2": 2.4e-3,
}
RIGID = """/**:
  ros__parameters:
    drive: {kind: rigid, output: linear}
    actuation: {signal: force}
    load: {mass: 12.5, viscous_friction: 30.0, coulomb_friction: 8.0, stiffness: 50.0}
    controller: {position: {kp: 20.0}, speed: {kp: 400.0}, command_limit: 900.0}
"""


def _drive(values: dict[str, float] | None = None) -> ec.DriveParameters:
    bench = ec.load_drive("bench")
    assert isinstance(bench, ec.DriveParameters)
    return ec.changed(bench, {**QUIET, "telemetry_rate": 10_000.0, **(values or {})})


def _in_mujoco(text: str, control: np.ndarray, period_s: float) -> tuple[np.ndarray, np.ndarray]:
    """Positions of rotor (rad) and rod (m) at the samples, for a control linear in between."""
    mujoco = pytest.importorskip("mujoco")
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    ticks = math.ceil(period_s / model.opt.timestep - 1e-9)
    model.opt.timestep = period_s / ticks
    found = np.empty((control.size, model.nq))
    for index, value in enumerate(control):
        found[index] = data.qpos
        after = control[min(index + 1, control.size - 1)]
        for tick in range(ticks):
            data.ctrl[0] = value + (after - value) * (tick + 0.5) / ticks
            mujoco.mj_step(model, data)
    return found[:, 0], found[:, 1]


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))


@pytest.mark.parametrize(
    ("faults", "most"),
    [
        ({}, 1e-4),
        ({key: value for key, value in WORN.items() if "coulomb" not in key}, 1e-4),
        # At reversals Coulomb friction is a stiff bristle here and a constraint there.
        (WORN, 1e-2),
    ],
    ids=["healthy", "worn", "worn, with Coulomb friction"],
)
def test_mujoco_moves_as_the_engine_does(
    faults: dict[str, float], most: float, capsys: pytest.CaptureFixture[str]
) -> None:
    """Driven by the engine's current, MuJoCo's rotor, rod and clearance move as the engine's do.

    The motor alone, no loop to hold it: what differs adds up.
    """
    drive = _drive(faults)
    run = ec.simulate(drive, MOVES, 2.0)
    text = mjcf(of(drive, "drive"), "motor")
    rotor, rod = _in_mujoco(text, run.current_q_a, 1.0 / run.rate_hz)
    ratio = drive.transmission.rod_per_rotor
    twist = rotor - rod / ratio
    apart = {
        "rotor": _rms(rotor - run.rotor_position_rad) / np.ptp(run.rotor_position_rad),
        "rod": _rms(rod - run.rod_position_m) / np.ptp(run.rod_position_m),
        "twist": _rms(twist - (run.rotor_position_rad - run.load_position_rad))
        / drive.transmission.backlash,
    }
    with capsys.disabled():
        said = ", ".join(f"{name} {share:.1e}" for name, share in apart.items())
        print(f"\nMuJoCo and the engine are apart by ({said}) of travel, travel and clearance")
    assert max(apart.values()) < most
    # The clearance is really crossed, and the comparison sees a wrong one.
    assert np.ptp(twist) > drive.transmission.backlash
    half = ec.changed(drive, {"transmission.backlash": 0.5 * drive.transmission.backlash})
    rotor, rod = _in_mujoco(mjcf(of(half, "drive"), "motor"), run.current_q_a, 1.0 / run.rate_hz)
    other = (
        _rms(rotor - rod / ratio - (run.rotor_position_rad - run.load_position_rad))
        / drive.transmission.backlash
    )
    assert other > 5.0 * apart["twist"]


def test_the_servo_follows_as_the_cascade_does() -> None:
    """In position control MuJoCo's servo lags as the cascade: apart by little beside the lag."""
    drive = _drive({"controller.speed.ki": 0.0})
    run = ec.simulate(drive, MOVES, 1.5)
    _, rod = _in_mujoco(mjcf(of(drive, "drive")), run.reference_position_m, 1.0 / run.rate_hz)
    lag = _rms(run.reference_position_m - run.rod_position_m)
    assert _rms(rod - run.rod_position_m) < 0.02 * lag


def test_what_cannot_be_expressed_is_listed_and_what_can_is_not() -> None:
    """Effects that are constants or loads are taken over in silence; every other one is named."""
    taken = of(_drive(WORN), "worn")
    assert not [one for one in taken.left_out if "effects." in one]
    cogging = {"amplitude_nm": 0.05, "periods_per_rev": 24.0}
    keys = {f"effects.cogging_torque.{name}": value for name, value in cogging.items()}
    keys["effects.resistance_error.resistance_ohm"] = 1.0
    lost = [one for one in of(_drive(keys), "x").left_out if "effects." in one]
    assert len(lost) == 2 and "cogging" in lost[0] and "resistance" in lost[1]
    plain = of(_drive(), "bench")
    assert any("integral" in one for one in plain.left_out)
    for text in (mjcf(plain), urdf(plain), sdf(plain)):
        for one in plain.left_out:
            assert one in text


def test_values_stand_in_each_formats_own_words() -> None:
    """Inertia, friction, damping, backlash, gear and gains of the worn drive, in each format."""
    drive = _drive(WORN)
    ratio = drive.transmission.rod_per_rotor
    made = of(drive, "worn")
    mass, friction, damping = 2.4e-3 / ratio**2, 0.08 / ratio, 1e-2 / ratio**2
    root = ElementTree.fromstring(mjcf(made))
    rod = root.find(".//joint[@name='rod']")
    assert rod is not None
    assert float(rod.attrib["frictionloss"]) == pytest.approx(friction)
    assert float(rod.attrib["damping"]) == pytest.approx(damping)
    assert float(rod.attrib["stiffness"]) == 2e4
    masses = [float(one.attrib["mass"]) for one in root.iter("inertial")]
    assert masses[1] == pytest.approx(mass)
    (tendon,) = root.iter("fixed")
    low, high = map(float, tendon.attrib["range"].split())
    assert high - low == pytest.approx(2.7e-3)
    (position,) = root.iter("position")
    servo = drive.controller.speed.kp * drive.motor.torque_constant / ratio**2
    assert float(position.attrib["kv"]) == pytest.approx(servo)
    assert float(position.attrib["kp"]) == pytest.approx(servo * drive.controller.position.kp)
    for root in (ElementTree.fromstring(urdf(made)), ElementTree.fromstring(sdf(made))):
        (rod,) = (one for one in root.iter("joint") if one.get("name") == "rod")
        assert rod.get("type") == "prismatic"
        told = {one.tag: {**one.attrib, "": one.text} for one in rod.iter()}
        where = told["dynamics"] if told["dynamics"].get("damping") else None
        said = (
            (where["damping"], where["friction"])
            if where
            else (told["damping"][""], told["friction"][""])
        )
        assert [float(one or "nan") for one in said] == pytest.approx([damping, friction])
        ratio_told = told["mimic"].get("multiplier") or told["multiplier"][""]
        assert float(ratio_told or "nan") == pytest.approx(ratio)


def test_the_urdf_is_one_that_others_can_read() -> None:
    """MuJoCo reads the URDF: masses, limits and friction as written; the root has no inertia."""
    mujoco = pytest.importorskip("mujoco")
    made = of(_drive(WORN), "worn")
    model = mujoco.MjModel.from_xml_string(urdf(made))
    names = [model.joint(index).name for index in range(model.njnt)]
    assert names == ["rotor", "rod"]
    assert model.body_mass[-1] == pytest.approx(made.output.inertia)
    assert model.joint("rod").range == pytest.approx([made.output.low, made.output.high])
    root = ElementTree.fromstring(urdf(made))
    assert root.find("link[@name='base_link']/inertial") is None


def test_a_rigid_drive_comes_back_from_mjcf(tmp_path: Path) -> None:
    """Mass, friction, spring and gains of a rigid drive survive the way to MJCF and back."""
    path = tmp_path / "rigid.yaml"
    path.write_text(RIGID, encoding="utf-8")
    own = load_model(path)
    assert isinstance(own, ec.Machine)
    (tmp_path / "rigid.xml").write_text(mjcf(of(own, "rigid")), encoding="utf-8")
    arguments = ["export", tmp_path / "rigid.xml", "--to", "rigid", "--out", tmp_path / "back.yaml"]
    assert main([str(one) for one in arguments]) == 0
    back = load_model(tmp_path / "back.yaml")
    assert isinstance(back, ec.Machine)
    for field in dataclasses.fields(own):
        one, other = (getattr(each, field.name) for each in (own, back))
        assert other == (pytest.approx(one) if isinstance(one, float) else one), field.name


def test_joints_of_other_peoples_files_are_read(tmp_path: Path) -> None:
    """Default classes, parallel axes, subtrees and gears of MJCF; dynamics and inertia of URDF."""
    scene = tmp_path / "scene.xml"
    scene.write_text(
        """<mujoco><default><joint damping="1"/><default class="arm"><joint frictionloss="2"/>
        </default></default><worldbody><body name="a" childclass="arm">
        <joint name="hinge" type="hinge" axis="0 0 2" pos="0.1 0 0" armature="0.5"/>
        <inertial pos="0.4 0 7" mass="3" diaginertia="0.1 0.2 0.3"/>
        <body name="b"><joint name="slide" type="slide" stiffness="9"/>
        <inertial pos="0 0 0" mass="4" diaginertia="1 1 1"/>
        <body name="c"><inertial pos="0 0 0" mass="5" diaginertia="1 1 1"/></body></body>
        </body></worldbody><actuator>
        <position name="p" joint="slide" kp="100" kv="10" gear="2" forcerange="-7 7"/></actuator>
        </mujoco>"""
    )
    hinge, slide = read_joint(scene, "hinge"), read_joint(scene, "slide")
    assert hinge.inertia == pytest.approx(0.5 + 0.3 + 3 * 0.3**2)
    assert (hinge.damping, hinge.friction, slide.damping) == (1.0, 2.0, 1.0)
    assert (slide.inertia, slide.stiffness, slide.friction) == (9.0, 9.0, 2.0)
    assert (slide.position_kp, slide.speed_kp, slide.effort) == (10.0, 40.0, 14.0)
    robot = tmp_path / "robot.urdf"
    robot.write_text(urdf(of(_drive(WORN), "worn")))
    rod = read_joint(robot, "rod")
    assert rod.linear and rod.inertia == pytest.approx(of(_drive(WORN), "worn").output.inertia)
    rotor = read_joint(robot, "rotor")
    assert rotor.inertia == pytest.approx(ec.load_drive("bench").motor.rotor_inertia)
    machine_from_flat(parameters(rotor), "rotor")


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("x.xml", "<mujoco>", "no XML"),
        ("x.xml", "<a/>", "expected MJCF"),
        ("x.xml", "<mujoco><worldbody/></mujoco>", "0 joints"),
        ("x.xml", "<mujoco><include file='y'/></mujoco>", "other files"),
        ("x.xml", "<!DOCTYPE a [<!ENTITY b 'c'>]><mujoco/>", "entities"),
        (
            "x.urdf",
            "<robot><joint name='j' type='prismatic'><dynamics damping='much'/></joint></robot>",
            "damping = 'much'",
        ),
        (
            "x.urdf",
            "<robot><joint name='j' type='prismatic'><dynamics damping='-1'/></joint></robot>",
            "load.viscous_friction",
        ),
    ],
)
def test_files_that_say_nothing_are_refused(
    name: str, text: str, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """An unusable MJCF or URDF ends with 2 and one line; nothing is written."""
    path, out = tmp_path / name, tmp_path / "out.yaml"
    path.write_text(text)
    assert main(["export", str(path), "--to", "rigid", "--out", str(out)]) == 2
    errors = capsys.readouterr().err
    assert said in errors and errors.count("\n") == 1 and not out.exists()


def test_a_drive_without_mass_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A rigid drive file that leaves the mass out says which key it takes."""
    path = tmp_path / "rigid.yaml"
    path.write_text(RIGID.replace("mass: 12.5, ", ""), encoding="utf-8")
    assert main(["export", str(path), "--to", "mjcf"]) == 2
    assert "load.mass is missing" in capsys.readouterr().err


def test_a_coupling_without_clearance_twists_in_mujoco_as_here() -> None:
    """Driven by the engine's current, the flanks never part: damper and spring pull, too."""
    drive = _drive({"transmission.backlash": 0.0, "transmission.contact_damping": 5e-3})
    run = ec.simulate(drive, MOVES, 1.0)
    text = mjcf(of(drive, "x"), "motor")
    rotor, rod = _in_mujoco(text, run.current_q_a, 1.0 / run.rate_hz)
    twist = run.rotor_position_rad - run.load_position_rad
    apart = rotor - rod / drive.transmission.rod_per_rotor - twist
    assert twist.min() < 0.0 < twist.max()
    assert _rms(apart) < 1e-3 * _rms(twist)


def test_a_piecewise_stiffness_is_told_of() -> None:
    """Of a flank in segments the chord is exported, and the list says so."""
    values: dict[str, Any] = {
        "transmission.stiffness": [1000.0, 5000.0],
        "transmission.stiffness_breaks": [2.0],
    }
    made: Mechanism = of(_drive(values), "soft")
    assert made.contact is not None and made.contact.stiffness == pytest.approx(1000.0)
    assert any("2 segments" in one for one in made.left_out)
