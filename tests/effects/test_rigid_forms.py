"""What an effect is in a rigid drive: one law, tick by tick and along a motion."""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from ecyl_ros.drive.drive_file import load_drive
from ecyl_ros.drive.rigid.machine import Machine
from ecyl_ros.drive.rigid.model import Acting
from ecyl_ros.drive.rigid.packed import model_of, plant_of
from ecyl_ros.drive.rigid.plant import step
from ecyl_ros.drive.rigid.units import Units
from ecyl_ros.effects.along import Along
from ecyl_ros.effects.catalogue import CATALOGUE, MODULES, RIGID
from ecyl_ros.effects.rigid_ports import PORTS
from ecyl_ros.effects.term import Fitted, Interval

T = np.linspace(0.0, 4.0, 4001)
MACHINE = Machine(kind="rigid", output="rotary", actuation="torque", gain=1.0, inertia=0.5)
VALUES = {
    "actuation_delay": {"delay": 0.0},
    "cogging_torque": {"amplitude": 0.7, "wave": 9.0, "phase": 0.4},
    "constant_load": {"load": 0.6},
    "direction_dependent_friction": {
        "coulomb_positive": 0.3,
        "coulomb_negative": 0.5,
        "viscous_positive": 0.2,
        "viscous_negative": 0.1,
    },
    "friction_drift": {"coulomb": 0.4, "rate": 0.05},
    "gravity_on_arm": {"amplitude": 1.2, "phase": -0.3},
    "load_dependent_friction": {"coefficient": 0.2},
    "local_jam": {"coulomb": 0.8, "position": 0.5, "width": 0.6},
    "periodic_disturbance": {"amplitude": 0.9, "frequency": 2.5, "phase": 1.0},
    "rotor_coulomb_friction": {"coulomb": 0.4},
    "rotor_inertia_error": {"inertia": 0.8},
    "rotor_viscous_friction": {"viscous": 0.3},
    "spring_load": {"stiffness": 2.0, "rest": 0.1},
    "stribeck_friction": {"coulomb": 0.3, "static": 0.5, "stribeck": 0.6},
    "torque_constant_error": {"per_ampere": 1.25},
    "torque_ripple": {"fraction": 0.2, "wave": 6.0, "phase": 0.2},
}


def _course() -> SimpleNamespace:
    """A motion both ways, its derivatives in closed form."""
    position, velocity = 1.3 * np.sin(2.0 * T) + 0.2 * T, 2.6 * np.cos(2.0 * T) + 0.2
    return SimpleNamespace(
        time_s=T,
        own_s=T,
        parts=(slice(0, T.size),),
        rate_hz=1000.0,
        position=position,
        raw_position=position,
        velocity=velocity,
        acceleration=-5.2 * np.sin(2.0 * T),
        quiet=lambda values: values,
        speed_noise=0.0,
        usable=np.ones(T.size, dtype=bool),
    )


def _asked(machine: Machine, course: SimpleNamespace) -> np.ndarray:
    """What the model asks along the motion, where `asked` and the constants are summed up."""
    model = model_of(machine, True)
    along = Along(course, machine, model, Units("N m", False), lambda along: 0.0 * along.sign)
    way = np.sign(course.velocity)
    made = (
        model.inertia * course.acceleration
        + np.where(way > 0, model.viscous[0], model.viscous[1]) * course.velocity
        + np.where(way > 0, model.coulomb[0], model.coulomb[1]) * way
        + model.constant
        + model.stiffness * course.position
    )
    for one in model.shapes:
        made = made + RIGID[one.name].asked(along, one.values, made)
    return made


@pytest.mark.parametrize("name", sorted(name for name in RIGID if "rotary" in RIGID[name].outputs))
def test_what_a_column_asks_moves_the_machine_as_measured(name: str) -> None:
    """Driven by the effort that its columns ask for, the compiled step accelerates as measured."""
    effects = (Acting(name, VALUES[name]),)
    machine = dataclasses.replace(MACHINE, constant=0.3, effects=effects)
    course = _course()
    effort = _asked(machine, course)
    if RIGID[name].of_effort:  # a share of the whole, itself included
        bare = _asked(dataclasses.replace(machine, effects=()), course)
        effort = bare / (1.0 - 0.2 * np.sin(6.0 * course.position + 0.2))
    plant, h = plant_of(model_of(machine, True)), 1e-6
    for row in range(50, T.size, 97):
        if abs(course.velocity[row]) < 0.05:
            continue
        a = course.acceleration[row]
        q, v = course.position[row], course.velocity[row]
        _, after, _ = step(plant, T[row], q, v, a, effort[row], 0.0, (0.0, 0.0), h)
        assert (after - v) / h == pytest.approx(a, abs=2e-4), (row, q, v)


def test_each_effect_acts_one_way() -> None:
    """A form is another value of a constant, or has one port and says what it asks."""
    for name, form in RIGID.items():
        ports = [port for port in PORTS if hasattr(MODULES[name], port)]
        assert len(ports) == (form.modify is None), name
        assert (form.coefficients is None) == (form.modify is not None), name


def test_a_rigid_effect_is_not_offered_to_a_cylinder() -> None:
    """The weight of an arm is in no cylinder's catalogue; all others are in both or in that."""
    assert set(RIGID) - set(CATALOGUE) == {"gravity_on_arm"}
    assert "gravity_on_arm" not in load_drive("bench").effects


@pytest.mark.parametrize(("low", "allowed"), [(0.4, True), (1.2, False)])
def test_a_ripple_of_more_than_the_torque_is_none(low: float, allowed: bool) -> None:
    """An interval from 0.4 on holds ripples that a motor may have; from 1.2 on it holds none."""
    fitted = SimpleNamespace(
        term=SimpleNamespace(low=()),
        values=np.array([low + 0.1, 0.0]),
        spans=[Interval("fraction", "1", low + 0.1, low, low + 0.2)],
    )
    why = RIGID["torque_ripple"].void(cast(Fitted, fitted))
    assert (why == "") is allowed
