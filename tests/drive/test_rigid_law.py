"""A learned law in a rigid drive: played, along a motion, and in its file."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from ecyl_ros.drive.law import Law
from ecyl_ros.drive.rigid.law import asked, counted_in, remembered
from ecyl_ros.drive.rigid.machine import Machine
from ecyl_ros.drive.rigid.machine_file import load_machine
from ecyl_ros.drive.rigid.packed import model_of, plant_of
from ecyl_ros.drive.rigid.plant import along
from ecyl_ros.errors import InputError

MASS = 20.0
FILE = Machine(kind="rigid", output="linear", actuation="force", gain=1.0, inertia=MASS)
PLACES = tuple(np.linspace(-0.2, 0.2, 81).tolist())
HEAD = """/**:
  ros__parameters:
    drive: {kind: rigid, output: linear}
    actuation: {signal: force}
    load: {mass: 20.0}
"""


def law(port: str, of: str, values: np.ndarray, **more: object) -> Law:
    """Over `PLACES` of one variable, N."""
    made = Law(port, (of,), (PLACES,), tuple(values.tolist()), **more)  # type: ignore[arg-type]
    return counted_in(made, "N", True)


def slid(machine: Machine, speed: float, seconds: float, h: float = 1e-4) -> np.ndarray:
    """Positions from 0 on under no effort, float64[n]."""
    n = round(seconds / h)
    plant = plant_of(model_of(machine, True))
    return along(plant, 0.0, 0.0, speed, np.zeros(n), np.zeros(n), np.zeros((n, 2)), h)[0]


def test_friction_over_the_way_takes_its_energy() -> None:
    """A level that rises with the way, 40 N/m q, stops a mass where 20 q^2 is M v^2 / 2, and holds
    it there; it acts alike forwards and backwards."""
    rubs = law("load_friction", "position", 40.0 * np.abs(np.array(PLACES)))
    machine = dataclasses.replace(FILE, learned=rubs, effects_unit="N")
    for way in (1.0, -1.0):
        found = slid(machine, 0.1 * way, 2.0)
        assert found[-1] == pytest.approx(0.1 * way * np.sqrt(MASS / 40.0), rel=3e-3)
        assert found[-1] == found[-5000]


def test_a_straight_law_of_position_is_a_spring() -> None:
    """A force of -300 N/m q swings a mass as the file's spring of 300 N/m does."""
    pulls = law("load_torque", "position", -300.0 * np.array(PLACES))
    learned = dataclasses.replace(FILE, learned=pulls, effects_unit="N")
    spring = dataclasses.replace(FILE, stiffness=300.0)
    np.testing.assert_allclose(slid(learned, 0.4, 3.0), slid(spring, 0.4, 3.0), atol=1e-9)


class _Course:
    """A motion both ways in closed form."""

    time_s = own_s = np.arange(4000) * 1e-3
    parts = (slice(0, 4000),)
    rate_hz = 1000.0
    position = 0.15 * np.sin(2.0 * time_s)
    velocity = 0.3 * np.cos(2.0 * time_s)


def test_along_a_motion_a_law_asks_for_what_it_gives() -> None:
    """A force that drives is less to ask for; a level is asked for the way it moves; the way since
    a reversal begins anew with each, and warmth follows the square of the effort."""
    motion = _Course()
    sign, still = np.sign(motion.velocity), np.zeros(4000)
    drives = law("load_torque", "position", np.array(PLACES))
    np.testing.assert_allclose(asked(drives, motion, sign, still), -motion.position, atol=1e-12)
    rubs = law("load_friction", "speed", np.full(81, 3.0))
    np.testing.assert_allclose(asked(rubs, motion, sign, still), 3.0 * sign)
    way = remembered(law("load_friction", "travel", np.zeros(81)), motion, still)[:, 1]
    turn = np.flatnonzero(np.diff(sign))[0] + 1
    assert way[turn - 1] == pytest.approx(0.15, rel=1e-3) and abs(way[turn]) < 1e-5
    warm = dataclasses.replace(law("load_friction", "heat", np.zeros(81)), time_constant_s=0.5)
    heat = remembered(warm, motion, np.full(4000, 2.0))[:, 0]
    np.testing.assert_allclose(heat, 4.0 * (1.0 - np.exp(-(motion.time_s + 1e-3) / 0.5)), rtol=1e-9)


def test_a_file_holds_a_law(tmp_path) -> None:
    """Port, variable and table come out as they stand, counted in N of the output."""
    path = tmp_path / "axis.yaml"
    table = "table: {at: [0.0, 0.1, 0.2], values: [1.0, 3.0, 2.0]}"
    law = f"{{port: load_friction, of: [speed], {table}}}"
    path.write_text(f"{HEAD}    effects: {{learned: {law}}}\n")
    found = load_machine(path)
    assert found.learned is not None and found.effects_unit == "N"
    assert found.learned.of == ("speed",) and found.learned.units == ("m/s",)
    assert found.learned.values == (1.0, 3.0, 2.0) and found.learned.unit == "N"


@pytest.mark.parametrize(
    ("learned", "said"),
    [
        (
            "port: rotor_torque, table: {values: [1.0]}",
            "did you mean load_torque?",
        ),
        (
            "port: load_torque, of: [current], table: {at: [0.0, 1.0], values: [1.0, 2.0]}",
            "of = 'cu",
        ),
        (
            "port: load_torque, unit: kN, table: {values: [1.0]}",
            "unit = 'kN', expected N, N m, A, V",
        ),
        ("unit: N", "learned.port is missing"),
    ],
)
def test_a_law_that_a_rigid_drive_cannot_have_is_one_line(
    tmp_path, learned: str, said: str
) -> None:
    """Another side's port, a variable it lacks, a unit that none is, a law without a port."""
    path = tmp_path / "axis.yaml"
    path.write_text(f"{HEAD}    effects: {{learned: {{{learned}}}}}\n")
    with pytest.raises(InputError) as refused:
        load_machine(path)
    assert said in str(refused.value) and "\n" not in str(refused.value)
    assert str(refused.value).startswith(str(path))
