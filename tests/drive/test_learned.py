"""A learned law in the drive, against effects that have a closed form, and as a drive file."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from ecyl_ros.drive.drive_file import drive_from_flat, drive_to_flat, load_drive
from ecyl_ros.drive.engine import simulate
from ecyl_ros.drive.law import Law
from ecyl_ros.effects.learned import places, segments
from ecyl_ros.errors import InputError

DRIVE = load_drive("bench")
RATIO = DRIVE.transmission.rod_per_rotor


def _reference(index: int) -> tuple[float, float]:
    """2 mm to and fro at 2 Hz."""
    angle = 4e-3 * math.pi * index
    return 2e-3 * math.sin(angle), 2e-3 * 4.0 * math.pi * math.cos(angle)


def _run(law: Law | None = None, **effects: dict[str, float]) -> np.ndarray:
    drive = dataclasses.replace(DRIVE, learned=law, effects=effects)
    return simulate(drive, _reference, 0.6).samples


@pytest.mark.parametrize(
    ("law", "effect", "values"),
    [
        (
            Law("load_torque", ("position",), ((-0.01, 0.01),), (1.0, -1.0)),
            "spring_load",
            {"stiffness_n_per_m": 100.0 / RATIO},
        ),
        (
            Law("load_friction", ("direction",), ((-1.0, 1.0),), (0.3, 0.3)),
            "load_coulomb_friction",
            {"coulomb_nm": 0.3},
        ),
        (
            Law("rotor_torque", ("speed",), ((-50.0, 0.0, 50.0),), (0.5, 0.0, -0.5)),
            "rotor_viscous_friction",
            {"viscous_nm_s_per_rad": 0.01},
        ),
        (Law("current_error", (), (), (0.05,)), "current_sensor_offset", {"offset_a": 0.05}),
        (
            Law("inverter_voltage", ("speed",), ((-50.0, 50.0),), (2.5, -2.5)),
            "back_emf_error",
            {"back_emf_v_s_per_rad": DRIVE.motor.back_emf_constant + 0.05},
        ),
    ],
)
def test_a_table_of_what_has_a_name_plays_what_has_the_name(law, effect, values):
    """Spring, Coulomb and viscous friction, offset and back-EMF as tables: the same motion."""
    bare, learned, named = _run(), _run(law), _run(**{effect: values})
    moved = np.abs(named - bare).max(axis=0)
    apart = np.abs(learned - named).max(axis=0)
    assert moved.max() > 0.0
    # Another order of rounding, which impacts of the flanks make more of.
    assert np.all(apart <= 1e-3 * moved + 1e-12)


def test_a_law_of_friction_adds_to_the_level_of_a_named_one():
    """0.1 N m by name and 0.2 N m by table on one contact: the motion of 0.3 N m by name."""
    law = Law("load_friction", ("direction",), ((-1.0, 1.0),), (0.2, 0.2))
    bare = _run(load_coulomb_friction={"coulomb_nm": 0.1})
    both = _run(law, load_coulomb_friction={"coulomb_nm": 0.1})
    named = _run(load_coulomb_friction={"coulomb_nm": 0.3})
    moved = np.abs(named - bare).max(axis=0)
    assert moved.max() > 0.0
    assert np.all(np.abs(both - named).max(axis=0) <= 1e-3 * moved + 1e-12)


def test_between_places_a_line_stays_a_line_and_beyond_them_the_value_holds():
    """Hermite's cubic gives back a straight line on uneven places, and no more than the ends."""
    at = np.sort(np.random.default_rng(1).uniform(-1.0, 1.0, 9))
    for x in np.linspace(-2.0, 2.0, 101):
        found = places(segments(at, 0.0), len(at), 0.0, x)
        value = sum(found[4 + k] * (3.0 * at[found[k]] - 1.0) for k in range(4))
        assert value == pytest.approx(3.0 * np.clip(x, at[0], at[-1]) - 1.0, abs=1e-12)


def test_a_periodic_table_goes_round():
    """A sine by 24 places a turn is a sine to 0.1 %, any number of turns away."""
    at = np.arange(24) * 2.0 * math.pi / 24
    for x in np.linspace(-30.0, 30.0, 301):
        found = places(segments(at, 2.0 * math.pi), 24, 2.0 * math.pi, x)
        value = sum(found[4 + k] * math.sin(at[found[k]]) for k in range(4))
        assert value == pytest.approx(math.sin(x), abs=1e-3)


def test_heat_and_travel_are_what_they_are_called():
    """A voltage in proportion to heat is the current squared behind a low-pass; travel begins
    again at each reversal."""
    law = Law("inverter_voltage", ("heat",), ((0.0, 1e-12),), (0.0, 0.0), (), 0.1)
    drive = dataclasses.replace(DRIVE, learned=law)
    from ecyl_ros.drive.packed import pack
    from ecyl_ros.drive.plant import CURRENT_Q, HEAT, TRAVEL, initial_state, plant_step

    params, state = pack(drive), initial_state()
    heat, travel, last = 0.0, 0.0, 0.0
    for tick in range(3000):
        plant_step(state, 0.0, 2.0 * math.sin(2e-3 * math.pi * tick), params)
        heat = state[CURRENT_Q] ** 2 + (heat - state[CURRENT_Q] ** 2) * math.exp(-1e-3)
        travel = state[1] * 1e-4 + (0.0 if travel * state[1] < 0.0 else travel)
        assert state[HEAT] == pytest.approx(heat, rel=1e-9)
        assert state[TRAVEL] == pytest.approx(travel, rel=1e-9, abs=1e-12)
        last = max(last, abs(travel))
    assert last > 0.0


def test_a_law_survives_its_drive_file():
    """Flat parameters and back: the same law, with two variables, periods and heat."""
    for law in (
        Law("load_torque", (), (), (0.4,)),
        Law("rod_error", ("position",), ((0.0, 0.001, 0.0015),), (0.0, 1e-3, 0.0), (0.002,)),
        Law("rotor_friction", ("heat", "speed"), ((0.0, 9.0), (-1.0, 1.0)), (1.0,) * 4, (), 2.0),
    ):
        drive = dataclasses.replace(DRIVE, learned=law)
        assert drive_from_flat(drive_to_flat(drive), "file").learned == law


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"port": "load_torqe"}, "effects.learned.port = 'load_torqe'; did you mean load_torque?"),
        ({"of": ["place"]}, "effects.learned.of = 'place'; expected one of position"),
        ({"table.at": [0.0, 0.0]}, "effects.learned.table.at, expected increasing places"),
        ({"table.values": [1.0]}, "effects.learned.table.values has 1 values, expected 2"),
        ({"table.values": [1.0, math.inf]}, "effects.learned.table.values = inf, expected finite"),
        ({"of": ["heat"]}, "effects.learned.time_constant is missing; heat needs it, s"),
        ({"period": [0.5]}, "effects.learned.period = 0.5, expected 0, or more than"),
        ({"colour": "red"}, "unknown key effects.learned.colour; learned has port, of"),
        ({"port": "rod_error", "of": ["torque"]}, "expected none of it at rod_error"),
    ],
)
def test_a_law_that_cannot_be_is_refused_by_its_key(changes, message):
    """One line names the key and what was expected."""
    given = {"port": "load_torque", "of": ["position"]}
    given |= {"table.at": [0.0, 1.0], "table.values": [0.0, 1.0]}
    flat = drive_to_flat(DRIVE)
    flat |= {f"effects.learned.{key}": value for key, value in (given | changes).items()}
    with pytest.raises(InputError) as refused:
        drive_from_flat(flat, "file")
    assert message in str(refused.value)
    assert "\n" not in str(refused.value)
