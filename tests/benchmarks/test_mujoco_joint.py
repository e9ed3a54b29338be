"""A drive file as MuJoCo's joint: the MJCF says the same machine."""

from __future__ import annotations

import sys
from pathlib import Path
from types import ModuleType
from xml.etree import ElementTree

import numpy as np
import pytest

FOLDER = str(Path(__file__).parents[2] / "benchmarks")
VALUES = {"inertia": 20.0, "damping": 30.0, "frictionloss": 8.0, "stiffness": 50.0, "bias": -12.0}


@pytest.fixture
def joint(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """The benchmark's module, which belongs to no package."""
    monkeypatch.syspath_prepend(FOLDER)
    import mujoco_joint

    monkeypatch.delitem(sys.modules, "mujoco_joint")
    return mujoco_joint


def _needs_sysid() -> None:
    """Skip without the toolbox: plain `mujoco` has a folder of its name with nothing in it."""
    sysid = pytest.importorskip("mujoco.sysid")
    if not hasattr(sysid, "create_initial_state"):
        pytest.skip("mujoco[sysid] is only in the benchmarks' venv")


def _problem(joint: ModuleType, linear: bool, samples: int, **more: object) -> object:
    nothing = np.zeros(samples)
    fields = {
        "linear": linear,
        "rate_hz": 500.0,
        **dict.fromkeys(
            ("effort", "position", "velocity", "smooth_position", "acceleration"), nothing
        ),
        "fitted": np.array([[0, samples]]),
        "held_out": np.array([[0, samples]]),
        "scale": np.ones(2),
        "start": np.array(list(VALUES.values())),
        "low": np.zeros(5),
        "high": np.ones(5),
        "springref": 0.1,
    }
    return joint.Problem(**{**fields, **more})


@pytest.mark.parametrize("linear", [True, False])
def test_the_mjcf_holds_every_value_in_its_place(joint: ModuleType, linear: bool) -> None:
    """Inertia is a slide's mass or a hinge's armature; the rest stands at joint and actuator."""
    root = ElementTree.fromstring(joint.mjcf(linear, VALUES, 1e-3, 0.1))
    found = {one.tag: one.attrib for one in root.iter()}
    moved = found["inertial"]["mass"] if linear else found["joint"]["armature"]
    assert float(moved) == VALUES["inertia"]
    assert float(found["joint"]["armature"]) == (0.0 if linear else VALUES["inertia"])
    assert found["joint"]["type"] == ("slide" if linear else "hinge")
    for name in ("damping", "frictionloss", "stiffness"):
        assert float(found["joint"][name]) == VALUES[name]
    assert float(found["joint"]["springref"]) == 0.1
    assert (float(found["general"]["gainprm"]), found["general"]["biastype"]) == (1.0, "affine")
    assert float(found["general"]["biasprm"]) == VALUES["bias"]


def test_a_drive_file_s_values_are_where_the_fit_begins(
    joint: ModuleType, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """The start asks for the file's effort, M a + d v + F + k q + C, wherever the spring is."""
    import sysid_posing

    from ecyl_ros.drive.rigid.machine_file import load_machine
    from ecyl_ros.recording.signals import Recording

    monkeypatch.delitem(sys.modules, "sysid_posing")
    path = tmp_path / "drive.yaml"
    path.write_text(
        "/**:\n  ros__parameters:\n    drive: {kind: rigid, output: linear}\n"
        "    actuation: {signal: force}\n    load: {mass: 20.0, viscous_friction: 30.0, "
        "coulomb_friction: 8.0, constant_load: 12.0, stiffness: 50.0}\n"
    )
    t = np.arange(6000) * 2e-3
    position = 0.3 + 0.1 * np.sin(2.0 * t) + 0.03 * np.sin(9.0 * t)
    recording = Recording(
        stamp_ns=np.round(t * 1e9).astype(np.int64),
        rod_position_m=position,
        rod_force_n=100.0 * np.cos(2.0 * t),
    )
    machine = load_machine(path)
    posed = sysid_posing.pose(sysid_posing.Subject("one", recording, machine, None, None, False))
    problem, known = sysid_posing.problem_of(posed)
    inertia, damping, level, stiffness, bias = problem["start"]
    assert known and (inertia, damping, level, stiffness) == (20.0, 30.0, 8.0, 50.0)
    for at in (0.0, 0.4):
        assert stiffness * (at - problem["springref"]) - bias == pytest.approx(50.0 * at + 12.0)
    assert np.all((problem["low"] <= problem["start"]) & (problem["start"] <= problem["high"]))
    windows = np.concatenate([problem["fitted"], problem["held_out"]])
    order = windows[np.argsort(windows[:, 0])]
    assert np.all(order[1:, 0] >= order[:-1, 1])  # no sample is fitted and held out


@pytest.mark.parametrize("linear", [True, False])
def test_mujoco_moves_and_inverts_the_joint_as_its_equation_says(
    joint: ModuleType, linear: bool
) -> None:
    """M dv/dt = effort + bias - d v - F - k (q - ref): by mj_inverse, and over a slide to rest."""
    _needs_sysid()
    speed, place, rate = np.array([0.3, -0.2]), np.array([0.2, 0.5]), np.array([1.5, -4.0])
    posed = _problem(joint, linear, 2, smooth_position=place, velocity=speed, acceleration=rate)
    wanted = 20.0 * rate + 30.0 * speed + 8.0 * np.sign(speed) + 50.0 * (place - 0.1) + 12.0
    made = joint.inverse(posed, posed.start)
    assert made == pytest.approx(wanted, rel=1e-4)

    samples = 400
    begun = {"smooth_position": np.zeros(samples), "velocity": np.full(samples, 1.0)}
    sliding = _problem(joint, linear, samples, effort=np.full(samples, 2.0), **begun)
    values = np.array([20.0, 0.0, 8.0, 0.0, -4.0])  # brakes with 8 + 4 - 2 = 10 N
    moved = joint.simulate(sliding, values, sliding.held_out)
    t = np.arange(samples) / 500.0
    assert moved[:, 1] == pytest.approx(1.0 - 10.0 / 20.0 * t, abs=1e-5)
    assert moved[:, 0] == pytest.approx(t - 0.25 * t**2, abs=1e-3)


def test_mujoco_sysid_finds_the_joint_that_made_the_recording(joint: ModuleType) -> None:
    """Fitted to a motion of MuJoCo's own, from values off by a third, it comes back to them."""
    _needs_sysid()
    samples = 1000
    t = np.arange(samples) / 500.0
    windows = np.array([[0, 400], [400, 1000]])
    truth = np.array([20.0, 30.0, 8.0, 50.0, -2.0])
    effort = 60.0 * np.sin(5.0 * t) + 20.0 * np.sin(17.0 * t)
    whole = _problem(joint, True, samples, effort=effort, held_out=np.array([[0, samples]]))
    moved = joint.simulate(whole, truth, whole.held_out)
    posed = _problem(
        joint,
        True,
        samples,
        effort=effort,
        position=moved[:, 0],
        velocity=moved[:, 1],
        smooth_position=moved[:, 0],
        fitted=windows,
        scale=moved.std(axis=0),
        start=truth * [1.3, 0.7, 0.7, 0.7, 1.3],
        low=np.array([2.0, 0.0, 0.0, 0.0, -60.0]),
        high=np.array([200.0, 120.0, 60.0, 500.0, 60.0]),
    )
    found, course = joint.fit(posed)
    assert course["rms_fitted"] < 1e-4 * course["rms_start"]
    assert found == pytest.approx(truth, rel=1e-3)
