"""An effect's finer form in its place, and its simpler form: begun from what is known already."""

from __future__ import annotations

import pytest
from other_make import replayed

from ecyl_ros.gap.compete.candidates import Candidates
from ecyl_ros.gap.compete.forms import Forms
from ecyl_ros.gap.fit.fit import Fit, Fitter
from ecyl_ros.gap.split import held_out


def _field(true: dict[str, dict[str, float]], names: tuple[str, ...]) -> Candidates:
    """Effects `names` on another make of machine that has those of `true`."""
    replay = replayed(true, seed=6)
    return Candidates(Fitter(replay, held_out(replay.time_s)), names)


def _by_direction(field: Candidates, forwards: float, backwards: float, rise: float = 0.0) -> Fit:
    """Friction by direction, fitted from levels, N m, and one rise with speed, N m s/rad."""
    near = field.fitter.evaluate(
        {
            "direction_dependent_friction": {
                "coulomb_positive_nm": forwards,
                "coulomb_negative_nm": backwards,
                "viscous_positive_nm_s_per_rad": rise,
                "viscous_negative_nm_s_per_rad": rise,
            }
        }
    )
    (best,) = field.polish([near])
    return best


def test_stribeck_friction_begins_again_beside_viscous_friction() -> None:
    """Coulomb and viscous friction come nearest while the fall from the static level is missing;
    with Stribeck friction in Coulomb's place noise is left, and its levels are the machine's."""
    stribeck = {"coulomb_nm": 0.13, "static_nm": 0.2, "stribeck_rad_s": 3.4}
    viscous = {"load_viscous_friction": {"viscous_nm_s_per_rad": 0.011}}
    names = ("rotor_coulomb_friction", "stribeck_friction", "load_viscous_friction")
    field = _field({"stribeck_friction": stribeck, **viscous}, names)
    near = field.fitter.evaluate({"rotor_coulomb_friction": {"coulomb_nm": 0.15}, **viscous})
    (best,) = field.polish([near])
    assert best.fitted > 3.0 * field.fitter.perfect**2
    found = Forms(field).finer(best)
    assert found.fitted < 1.3 * field.fitter.perfect**2
    assert set(found.names) == {"stribeck_friction", "load_viscous_friction"}
    for name in ("coulomb_nm", "static_nm"):
        assert found.values["stribeck_friction"][name] == pytest.approx(stribeck[name], rel=0.03)


def test_a_finer_form_that_adds_nothing_takes_no_place() -> None:
    """Coulomb friction a hair off its best: Stribeck friction without a surplus at rest comes a
    little closer, being the same, and does not replace it."""
    true = {"rotor_coulomb_friction": {"coulomb_nm": 0.2}}
    field = _field(true, ("rotor_coulomb_friction", "stribeck_friction"))
    near = field.fitter.evaluate({"rotor_coulomb_friction": {"coulomb_nm": 0.2}})
    ((values,),) = (one.values.values() for one in field.polish([near]))
    off = {**values, "coulomb_nm": 1.0002 * values["coulomb_nm"]}
    near = field.fitter.evaluate({"rotor_coulomb_friction": off})
    assert field.polish([near])[0].fitted < near.fitted
    assert Forms(field).finer(near) is near


def test_friction_that_is_the_same_both_ways_is_one_level() -> None:
    """Friction by direction that has found how the contact gives: the plain level begins with that,
    and takes its place."""
    true = {"load_coulomb_friction": {"coulomb_nm": 0.26}}
    field = _field(true, ("load_coulomb_friction", "direction_dependent_friction"))
    best = _by_direction(field, 0.26, 0.26)
    found = Forms(field).simplified(best)
    assert found.names == ("load_coulomb_friction",)
    assert found.values["load_coulomb_friction"]["coulomb_nm"] == pytest.approx(0.26, rel=0.01)


def test_friction_by_direction_gives_way_to_a_level_beside_a_load() -> None:
    """A load larger than the friction: one direction's level is none, and the fit stays far from
    the floor; begun from it, one level and the load reach it at the machine's values."""
    true = {"load_coulomb_friction": {"coulomb_nm": 0.0576}, "constant_load": {"force_n": -42.5}}
    field = _field(true, (*true, "load_viscous_friction", "direction_dependent_friction"))
    best = _by_direction(field, 1e-4, 0.12)
    assert best.fitted > 2.0 * field.fitter.perfect**2
    found = Forms(field).simplified(best)
    assert set(found.names) == set(true)
    assert found.fitted < 1.3 * field.fitter.perfect**2
    assert found.values["constant_load"]["force_n"] == pytest.approx(-42.5, rel=0.03)


def test_friction_by_direction_gives_way_to_a_level_beside_drag_of_the_rotor() -> None:
    """Drag of the rotor rises on the load as well, but not where the flanks part: begun from what
    comes near, a level of the load and drag of the rotor reach the floor, and not both on one."""
    true = {
        "load_coulomb_friction": {"coulomb_nm": 0.12},
        "rotor_viscous_friction": {"viscous_nm_s_per_rad": 0.02},
    }
    field = _field(true, (*true, "load_viscous_friction", "direction_dependent_friction"))
    best = _by_direction(field, 0.12, 0.12, 0.02)
    assert best.fitted > 2.0 * field.fitter.perfect**2
    found = Forms(field).simplified(best)
    assert set(found.names) == set(true)
    assert found.fitted < 1.3 * field.fitter.perfect**2
    drag = found.values["rotor_viscous_friction"]["viscous_nm_s_per_rad"]
    assert drag == pytest.approx(0.02, rel=0.03)


def test_a_set_of_two_plain_forms_takes_the_place_of_two_general_ones() -> None:
    """Friction by direction and a shaft that hardens can be both what is plain: told at once, where
    neither alone comes near."""
    true = {
        "load_coulomb_friction": {"coulomb_nm": 0.16},
        "stiffness_error": {"stiffness_nm_per_rad": 530.0},
    }
    field = _field(true, (*true, "direction_dependent_friction", "stiffness_hardening"))
    general = {
        "direction_dependent_friction": {
            "coulomb_positive_nm": 0.16,
            "coulomb_negative_nm": 0.16,
            "viscous_positive_nm_s_per_rad": 0.0,
            "viscous_negative_nm_s_per_rad": 0.0,
        },
        "stiffness_hardening": {"share": 0.082, "torque_nm": 2.0},
    }
    plain, best = field.polish([field.fitter.evaluate(values) for values in (true, general)])
    assert Forms(field).simplified(best, [best, plain]) is plain
