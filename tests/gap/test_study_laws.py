"""How a study scores what was described: laws as drawn, withheld effects, laws beside the truth."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from ecyl_ros.gap.study.case import Case
from ecyl_ros.gap.study.cylinder.stage import hidden_phases
from ecyl_ros.gap.study.examine import Outcome
from ecyl_ros.gap.study.score.figures import figures
from ecyl_ros.gap.study.score.laws import law_lines
from ecyl_ros.gap.study.score.own_curve import has_own_curve, off_own_curve

ROD_PER_ROTOR_M = 1.5e-3
SPEEDS = np.linspace(-120.0, 120.0, 25)
ANGLES = np.linspace(0.0, 2.0 * np.pi, 48, endpoint=False)


def _withheld(name: str, **values: float) -> Case:
    facts = {"rod_per_rotor_m": ROD_PER_ROTOR_M}
    return Case(0, 7, "withheld", {name: values}, (name,), facts=facts)


def _law(port: str, of: list[str], at: np.ndarray, values: np.ndarray) -> dict:
    table = {"at": list(at), "values": list(values), "seen": [True] * len(at)}
    table["half_95"] = [0.01] * len(at)
    return {"port": port, "of": of, "table": table, "shrink": 0.99, "turns": {}}


def _outcome(case: Case, law: dict | None) -> Outcome:
    said = {
        "verdict": "described" if law else "explained",
        "location": {"block": None},
        "causes": [],
        "gap": {"before": 1.0, "after": 0.1, "floor": 0.1, "shrink": 0.99, "held_out": True},
    }
    if law:
        said["law"] = law
    return Outcome(case.index, said, None, 1.0)


FRICTION = _withheld("rotor_viscous_friction", viscous_nm_s_per_rad=2e-3)
SPRING = _withheld("spring_load", stiffness_n_per_m=3e4)
COGGING = _withheld("cogging_torque", amplitude_nm=0.05, periods_per_rev=6.0)


def test_the_effect_itself_is_off_its_curve_by_nothing() -> None:
    """Worked by hand: a drag, the same as a torque against the motion, a spring, a wave."""
    drag = 2e-3 * np.abs(SPEEDS)
    ways = np.linspace(-0.1, 0.1, 21)
    wave = 0.05 * np.sin(6.0 * ANGLES + hidden_phases("cogging_torque", 7)[0])
    for case, law in (
        (FRICTION, _law("rotor_friction", ["speed"], SPEEDS, drag)),
        (FRICTION, _law("rotor_torque", ["speed"], SPEEDS, -2e-3 * SPEEDS)),
        (SPRING, _law("load_torque", ["position"], ways, -3e4 * ROD_PER_ROTOR_M * ways)),
        (COGGING, _law("rotor_torque", ["rotor_angle"], ANGLES, wave)),
    ):
        assert off_own_curve(law, case) == pytest.approx(0.0, abs=1e-12)


def test_a_map_of_two_variables_is_scored_row_by_row() -> None:
    """A wave described over the angle and the speed, and then a fifth too large at one speed."""
    wave = 0.05 * np.sin(6.0 * ANGLES + hidden_phases("cogging_torque", 7)[0])
    law = _law("rotor_torque", ["rotor_angle", "speed"], ANGLES, np.repeat(wave, 2))
    law["table"] |= {"at_2": [-50.0, 50.0], "seen": [True] * 96, "half_95": [0.01] * 96}
    assert off_own_curve(law, COGGING) == pytest.approx(0.0, abs=1e-12)
    law["table"]["values"][1::2] = list(1.2 * wave)
    assert off_own_curve(law, COGGING) == pytest.approx(0.2 / np.sqrt(2.0))


def test_another_size_place_or_variable_is_not_its_own_curve() -> None:
    """A fifth too large is a fifth off; at another port, or of something else, nothing is said."""
    drag = 2e-3 * np.abs(SPEEDS)
    law = _law("rotor_friction", ["speed"], SPEEDS, 1.2 * drag)
    assert off_own_curve(law, FRICTION) == pytest.approx(0.2)
    assert off_own_curve(_law("load_friction", ["speed"], SPEEDS, drag), FRICTION) is None
    assert off_own_curve(_law("rotor_friction", ["position"], SPEEDS, drag), FRICTION) is None


def test_an_angle_that_never_went_round_may_be_told_as_a_position() -> None:
    """The same wave over the stroke is its own curve after 1.2 turns, and not after three."""
    turned = np.linspace(0.0, 1.2 * 2.0 * np.pi, 48)
    wave = 0.05 * np.sin(6.0 * turned + hidden_phases("cogging_torque", 7)[0])
    law = _law("rotor_torque", ["position"], ROD_PER_ROTOR_M * turned, wave)
    assert off_own_curve(law | {"turns": {"rotor_angle": 1.2}}, COGGING) == pytest.approx(0.0)
    assert off_own_curve(law | {"turns": {"rotor_angle": 3.0}}, COGGING) is None


def test_a_rigid_drive_has_no_curve_at_the_ports_of_a_cylinder() -> None:
    """Its effects of the same names have other parameters: they are not scored."""
    assert has_own_curve(SPRING)
    assert not has_own_curve(dataclasses.replace(SPRING, drives="rigid"))


def test_only_what_was_visited_counts() -> None:
    """Wrong where nothing was seen is not wrong; where nothing was seen at all, nothing is said."""
    law = _law("rotor_friction", ["speed"], SPEEDS, 2e-3 * np.abs(SPEEDS))
    law["table"]["values"][0] = 9.0
    law["table"]["seen"][0] = False
    assert off_own_curve(law, FRICTION) == pytest.approx(0.0, abs=1e-12)
    law["table"]["seen"] = [False] * len(SPEEDS)
    assert off_own_curve(law, FRICTION) is None


def test_figures_count_withheld_curves_and_laws_beside_the_truth() -> None:
    """Of two withheld one comes back; of two named machines one has a law invented beside it."""
    right = _law("rotor_friction", ["speed"], SPEEDS, 2e-3 * np.abs(SPEEDS))
    named = Case(1, 3, "single", {"backlash_error": {"backlash_rad": 0.01}})
    judged = [
        (FRICTION, _outcome(FRICTION, right)),
        (SPRING, _outcome(SPRING, right)),
        (COGGING, _outcome(COGGING, None)),
        (named, _outcome(named, None)),
        (named, _outcome(named, right)),
    ]
    found = {one.name: one for one in figures(judged)}
    described, own = found["withheld: described"], found["withheld: its own curve, of those"]
    assert (described.right, described.count) == (2, 3)
    assert (own.right, own.count) == (1, 2)
    beside = found["no law beside the truth"]
    assert (beside.right, beside.count) == (1, 2)
    lines = law_lines(judged)
    assert "off its own curve by 0.0 %" in lines[0] and "not its own curve" in lines[1]
    assert lines[2].endswith("not described") and len(lines) == 3
