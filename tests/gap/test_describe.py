"""A cause that the library lacks, described: found where it is, refused where there is none."""

from __future__ import annotations

import dataclasses
import math
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from guess_samples import guess as guess_of
from report_samples import diagnosis

from ecyl_ros.drive.drive_file import load_drive
from ecyl_ros.drive.law import Law
from ecyl_ros.gap.compete.competition import Competition
from ecyl_ros.gap.describe.apply import described, with_description
from ecyl_ros.gap.describe.axis import Axis, columns, roughness
from ecyl_ros.gap.describe.balance import Balance, balances_of
from ecyl_ros.gap.describe.choose import Choice, choose
from ecyl_ros.gap.describe.coordinates import without_scale
from ecyl_ros.gap.describe.describe import Described, describe
from ecyl_ros.gap.describe.formula import formula
from ecyl_ros.gap.describe.guess import Guess
from ecyl_ros.gap.describe.missing import TORQUE, VOLTAGE, missing
from ecyl_ros.gap.describe.motion import Motion
from ecyl_ros.gap.describe.nearest import played_curve
from ecyl_ros.gap.describe.play import CLOSELY, Playing, evaluate
from ecyl_ros.gap.describe.regress import Rows, regress
from ecyl_ros.gap.diagnosis import Diagnosis, Series
from ecyl_ros.gap.fit.fit import Fitter
from ecyl_ros.gap.fit.robust import misfit
from ecyl_ros.gap.replay.replay import Replay
from ecyl_ros.gap.report.page import report_html
from ecyl_ros.gap.report.terminal import summary
from ecyl_ros.gap.split import held_out_of
from ecyl_ros.gap.study.case import Case
from ecyl_ros.gap.study.cylinder.cases import complete_case, record_case, stated
from ecyl_ros.gap.study.cylinder.unnamed import UNNAMED
from ecyl_ros.gap.study.score.laws import covered, of_right, port_right, truth
from ecyl_ros.gap.twin.closer import write_twin

DRIVE = load_drive("bench")
SHEET = 0.02


@cache
def _case(name: str | None, seed: int = 1481, end_s: float = 6.0) -> tuple[Case, Fitter]:
    """A stand-in off its sheet by 2 %, with a law that has no name, and the fits of its bag."""
    effects = {} if name is None else {name: {}}
    kind = "none" if name is None else "law"
    case = Case(index=0, seed=seed, kind=kind, effects=effects, sheet=SHEET)
    case = complete_case(case, DRIVE)
    recording = record_case(case, DRIVE).slice(0.0, end_s)
    replay = Replay(recording, stated(DRIVE, SHEET), "case")
    held = held_out_of(replay.time_s, replay.gap({}), replay.usable)
    return case, Fitter(replay, held)


def _alone(fitter: Fitter) -> Competition:
    """A competition in which nothing earned its place."""
    return Competition(fitter.nominal, fitter.nominal, (), fitter.nominal, (), {})


def _chosen(fitter: Fitter, kinds: tuple[str, ...]) -> tuple[Choice, Balance]:
    """What comes of the sets of variables at some kinds of one balance, and that balance."""
    motion = Motion.of(fitter.replay, fitter.replay.full({}))
    balances = balances_of(missing(motion, fitter.sheet), motion, fitter.rows)
    choice = choose(kinds, balances, motion)
    assert choice is not None
    return choice, balances[kinds[0]]


@cache
def _cubic() -> tuple[Case, Fitter, Described]:
    case, fitter = _case("x_law_cubic_drag")
    found = describe(fitter, _alone(fitter), lambda share: None)
    assert found is not None
    return case, fitter, found


def test_laws_are_looked_for_in_the_balances_that_are_known():
    """Flanks that never carry the load while it moves leave torque and rod unknown: what is missing
    may then be a voltage, and no error of the current, which needs the torque as well."""
    _, fitter = _case("x_law_cubic_drag")
    motion = Motion.of(fitter.replay, fitter.replay.full({}))
    found = missing(motion, fitter.sheet)
    apart = {
        name: one if name == VOLTAGE else dataclasses.replace(one, rows=one.rows[:0])
        for name, one in found.items()
    }
    assert set(balances_of(found, motion, fitter.rows)) >= {"torque", "current_error"}
    assert set(balances_of(apart, motion, fitter.rows)) == {"inverter_voltage"}


def test_a_law_is_found_at_its_port_with_its_variable_and_its_curve():
    """A torque of the speed cubed on the rotor, the sheet off by 2 %: nine tenths of the gap."""
    case, _, found = _cubic()
    law, kind = found.description.as_json(), UNNAMED["x_law_cubic_drag"]
    assert port_right(law, kind)
    assert of_right(law, kind)
    assert law["shrink"] >= 0.9
    assert law["chance"] <= 0.01
    share = covered(law, kind, case)
    assert share is None or share >= 0.8  # None: told as a drag, which it is as well


def test_a_place_is_not_mistaken_for_the_current_that_answers_it():
    """Detents along the stroke: current and torque predict what they answer; the loop tells."""
    case, fitter = _case("x_law_detents")
    found = describe(fitter, _alone(fitter), lambda share: None)
    assert found is not None
    law, kind = found.description.as_json(), UNNAMED["x_law_detents"]
    assert port_right(law, kind)
    assert law["of"] == ["position"]
    assert law["shrink"] >= 0.8
    share = covered(law, kind, case)
    assert share is not None
    assert share >= 0.8


@pytest.mark.parametrize(
    ("name", "seed", "end_s"),
    [
        ("x_law_drag_of_rotor_angle", 305669494, 8.0),
        ("x_law_current_reading_bends", 1070867289, 5.0),
    ],
)
def test_of_laws_that_come_near_in_the_loop_the_one_that_predicts_best_stands(
    name: str, seed: int, end_s: float
) -> None:
    """A drag of the rotor's angle that fits nearly as well over the position, and an error of the
    current's reading that a torque of the current resembles: port and variables are the truth's."""
    _, fitter = _case(name, seed, end_s)
    found = describe(fitter, _alone(fitter), lambda share: None)
    assert found is not None
    law, kind = found.description.as_json(), UNNAMED[name]
    assert port_right(law, kind)
    assert of_right(law, kind)


@pytest.mark.parametrize(
    ("name", "seed", "kinds", "of"),
    [
        ("x_law_drag_of_heat", 668561127, ("torque", "friction"), ("heat",)),
        ("x_law_winding_of_heat", 57837258, ("inverter_voltage",), ("current", "heat")),
    ],
)
def test_the_time_constant_of_heat_is_found_between_those_that_are_tried(
    name: str, seed: int, kinds: tuple[str, ...], of: tuple[str, ...]
) -> None:
    """Within 5 % of the drawn one: of a drag that grows with heat, and of a winding that heats, of
    which heat alone tells nothing."""
    case, fitter = _case(name, seed, 12.0)
    choice, _ = _chosen(fitter, kinds)
    assert choice.best.of == of
    (drawn,) = case.effects.values()
    assert choice.best.time_constant_s == pytest.approx(drawn["heat_s"], rel=0.05)


def test_a_band_holds_the_truth_where_impacts_would_hold_the_fit():
    """A drag of speed squared that the sheet's friction is exchanged for: impacts of the flanks,
    which answer with spikes, do not keep the law where it was."""
    case, fitter = _case("x_law_drag_of_speed_squared", 1139385314)
    choice, balance = _chosen(fitter, ("friction",))
    assert choice.best.of == ("speed",)
    pulls = fitter.sheet.at_nominal
    pulls[list(balance.pulled)] = choice.best.found.pulls
    playing = Playing(fitter, choice.best, "load_friction", pulls)
    playing.through(CLOSELY)
    played = playing.known()
    (places,) = played.law.at
    true = truth(case, ("speed",), [np.array(places)])
    assert true is not None
    seen = balance.seen(choice.best)
    values = np.maximum(np.array(played.law.values), 0.0)
    inside = np.abs(values - true)[seen] <= played.half[seen]
    assert np.mean(inside) >= 0.9
    assert np.median(played.half[seen]) < 0.1 * np.ptp(true[seen])  # and says something


def test_the_twin_with_the_law_stands_where_the_description_said(tmp_path: Path):
    """The file that is written, replayed, leaves what was said; and it is the law, rounded."""
    _, fitter, found = _cubic()
    told = _told(fitter, found)
    out = tmp_path / "twin.yaml"
    write_twin(told, "bench", out)
    twin = load_drive(out)
    assert twin.learned is not None
    assert np.allclose(twin.learned.values, found.played.law.values, rtol=1e-8)
    replay = Replay(fitter.replay.recording, twin, "case")
    fitted = Fitter(replay, fitter.held)
    assert misfit(fitted.nominal.left) == pytest.approx(misfit(found.played.left), rel=0.05)


def _told(fitter: Fitter, found: Described) -> Diagnosis:
    """An unexplained diagnosis of the case, described."""
    replay = fitter.replay
    bare = replay.simulate({})
    series = Series(
        replay.time_s, replay.reference_m, replay.recorded, bare, bare, fitter.held, replay.usable
    )
    unexplained = dataclasses.replace(diagnosis("unexplained"), series=series)
    return described(unexplained, found, fitter)


def test_a_law_of_torque_grows_with_the_scale_that_no_motion_shows():
    """All torques of the sheet and the law larger by a thousandth leave the same gap, where the law
    alone does not; what a fit's derivatives hold along that is taken out of them."""
    _, fitter, found = _cubic()
    played = found.played
    values = np.array(played.law.values)
    guess = Guess("torque", ("speed",), (), 0.0, guess_of(("speed",), np.ones(4), 1.0).found)
    guess = guess.with_values(values)
    along = values[None] / np.sqrt(np.mean(values**2))
    taken_out = without_scale(fitter, guess, played.law.port, along)
    assert taken_out is not None
    point = np.concatenate([np.zeros(1), played.pulls])
    slopes = np.eye(point.size)
    taken_out(slopes, point)
    (moved,) = np.linalg.svd(slopes)[2][-1:]  # the one direction that nothing is left along
    step = 1e-3 * np.sqrt(np.mean(values**2)) / moved[0]
    law = dataclasses.replace(played.law, values=tuple(1.001 * values))
    together = evaluate(fitter, law, played.pulls + step * moved[1:]).gap
    alone = evaluate(fitter, law, played.pulls).gap
    off, off_alone = (np.quantile(np.abs(one - played.gap), 0.9) for one in (together, alone))
    assert off < 0.01 * off_alone


def test_words_and_page_say_what_was_found():
    """Terminal, JSON and page: verdict, port, variable, formula's unit, curve with band."""
    _, fitter, found = _cubic()
    told = _told(fitter, found)
    text = summary(told)
    assert "Nothing in the catalogue explains the gap, but it can be described" in text
    assert "a torque on the rotor" in text or "a drag on the rotor" in text
    assert "depends on    speed" in text
    page = report_html(told)
    assert "<h1>Described</h1>" in page
    assert 'class="band after"' in page and 'class="dots"' in page
    data = told.as_json()
    assert data["verdict"] == "described" and data["causes"] == []
    assert data["law"]["of"] == ["speed"] and data["location"]["block"] == "motor_mechanical"


def test_a_named_effect_is_drawn_over_the_law_as_it_acts():
    """Viscous friction of 5 mN m s/rad, played, lacks just that torque over the speed."""
    _, fitter, found = _cubic()
    acts = {"rotor_viscous_friction": {"viscous_nm_s_per_rad": 5e-3}}
    nominal = fitter.nominal
    named = dataclasses.replace(nominal, values=acts, pulls=np.zeros_like(nominal.pulls))
    law = dataclasses.replace(found.played.law, port="rotor_torque")
    near = played_curve(fitter, named, law, guess_of(("speed",), np.ones(4), 1.0), TORQUE, 1.0)
    assert near is not None
    slow = np.abs(near[0]) < 0.8 * np.abs(near[0]).max()  # at the ends it is passed too seldom
    assert np.median(np.abs(near[1] + 5e-3 * near[0])[slow]) < 2e-3
    assert np.polyfit(near[0][slow], near[1][slow], 1)[0] == pytest.approx(-5e-3, rel=0.05)


def test_a_machine_within_its_sheet_is_not_described():
    """Noise and constants off by 2 % never become a law."""
    _, fitter = _case(None)
    assert describe(fitter, _alone(fitter), lambda share: None) is None


def test_only_what_is_unexplained_is_described():
    """A diagnosis with another verdict comes back as it is."""
    named = diagnosis("no_gap")
    assert with_description(named, None, None) is named  # type: ignore[arg-type]


def _rows(target: np.ndarray, count: int) -> Rows:
    block = np.arange(count) // 40
    return Rows(target, np.zeros((0, count)), block, np.ones(count), float(count), np.zeros(0))


def test_prediction_finds_the_smoothness_that_the_truth_has():
    """A straight line is fitted with few degrees of freedom, a fast wave with many, both well."""
    rng = np.random.default_rng(3)
    x = rng.uniform(-1.0, 1.0, 800)
    axis = (Axis.over("position", x),)
    law, rough = columns(axis, [x], len(x)), roughness(axis)
    found = {}
    for name, drawn in (("line", 5.0 * x), ("wave", 5.0 * np.sin(15.0 * x))):
        rows = _rows(drawn + rng.standard_normal(len(x)), len(x))
        found[name] = regress(rows, law, rough, 13.0)
        off = found[name].values @ law - drawn
        assert float(np.sqrt(np.mean(off**2))) < 0.35
        assert found[name].error < 1.2
    assert found["line"].freedom < 8.0 < found["wave"].freedom


def test_a_law_beside_a_sheet_bent_by_tens_of_tolerances_predicts_nothing():
    """What a constant off by 40 tolerances could do as well: the law that does it stands before one
    of something else beside that constant."""
    rng = np.random.default_rng(4)
    x, other = rng.uniform(-1.0, 1.0, (2, 800))
    bare = _rows(40.0 * x + rng.standard_normal(x.size), x.size)
    rows = dataclasses.replace(bare, sheet=x[None], growth=np.zeros(1))
    found = []
    for values in (x, other):
        axis = (Axis.over("position", values),)
        found.append(regress(rows, columns(axis, [values], x.size), roughness(axis), 1.0))
    right, wrong = found
    assert np.abs(wrong.pulls).max() > 30.0  # it predicts, by its own figure
    assert right.error < 2.0 and wrong.error > 100.0 * right.error


def test_a_straight_law_does_not_bend_the_constant_that_it_is_exchangeable_with():
    """What a drag of the speed and a viscous friction of the sheet could both be is the law's,
    however smooth the data choose it: the constant costs, the law does not."""
    rng = np.random.default_rng(6)
    x = rng.uniform(-1.0, 1.0, 800)
    rows = dataclasses.replace(
        _rows(5.0 * x + rng.standard_normal(x.size), x.size), sheet=x[None], growth=np.zeros(1)
    )
    axis = (Axis.over("speed", x),)
    found = regress(rows, columns(axis, [x], x.size), roughness(axis), 1.0)
    assert abs(found.pulls[0]) < 1e-3
    assert np.polyfit(axis[0].at, found.values, 1)[0] == pytest.approx(5.0, rel=0.05)


def test_noise_smaller_than_stated_makes_the_band_of_a_law_smaller():
    """A floor that holds what nobody could repeat is refuted by a law that predicts better."""
    rng = np.random.default_rng(8)
    x = rng.uniform(-1.0, 1.0, 800)
    axis = (Axis.over("speed", x),)
    wide = {}
    for noise in (1.0, 0.1):
        rows = _rows(5.0 * x**2 + noise * rng.standard_normal(x.size), x.size)
        found = regress(rows, columns(axis, [x], x.size), roughness(axis), 1.0)
        wide[noise] = np.sqrt(np.diag(found.covariance)).mean()
        off = found.values - 5.0 * axis[0].at ** 2
        assert np.sqrt(np.mean(off**2)) < 2.0 * wide[noise]
    assert wide[0.1] < 0.3 * wide[1.0]


def test_what_a_balance_leaves_does_not_shrink_torque_constant_and_inertia_together():
    """A balance leaves less if all its torques are smaller, and so is the law beside them; counted
    in the noise that the constants make of the sensors', it does not."""
    rng = np.random.default_rng(7)
    speed, of_inertia = rng.uniform(-1.0, 1.0, 800), 60.0 * rng.standard_normal(800)
    noise = 5.0 * rng.standard_normal(800)
    of_current = of_inertia - 30.0 * speed + noise
    sheet = 0.04 * np.array([-of_inertia, of_current])
    bare = dataclasses.replace(_rows(of_inertia - of_current, 800), sheet=sheet)
    axis = (Axis.over("speed", speed),)
    law = columns(axis, [speed], speed.size)
    slope, pulls = {}, {}
    for name, growth in (("raw", np.zeros(2)), ("counted", np.array([0.0, 0.04]))):
        rows = dataclasses.replace(bare, growth=growth)
        found = regress(rows, law, roughness(axis), 25.0)
        slope[name] = np.polyfit(axis[0].at, found.values, 1)[0]
        pulls[name] = found.pulls
    assert np.all(pulls["raw"] < -1.0)
    assert np.all(np.abs(pulls["counted"]) < 0.3)
    assert abs(slope["counted"] - 30.0) < 0.3 * abs(slope["raw"] - 30.0)


def test_a_law_spans_all_that_was_visited():
    """Places reach the rarest value, where a law may be largest."""
    x = np.concatenate([np.zeros(5000), [-1.0, 2.0]])
    at = Axis.over("current", x).at
    assert (at[0], at[-1]) == (-1.0, 2.0)


def test_a_formula_is_the_shortest_that_does_as_well():
    """A cube, a wave of the turn and a product come back as such, with their units."""
    w = np.linspace(-10.0, 10.0, 24)
    law = Law("rotor_torque", ("speed",), (tuple(w),), tuple(-2e-3 * w**3))
    assert formula(law, np.zeros(24)) == "-0.002 N m/(rad/s)^3 w^3"
    a = np.arange(48) * 2.0 * math.pi / 48
    law = Law("rotor_torque", ("rotor_angle",), (tuple(a),), tuple(0.1 * np.sin(3.0 * a)))
    assert formula(law, np.zeros(48)) == "0.1 N m sin(3a)"
    noise = np.random.default_rng(1).standard_normal(24)
    law = Law("rotor_torque", ("speed",), (tuple(w),), tuple(noise))
    assert formula(law, np.zeros(24)) is None


def test_a_formula_has_no_wave_that_the_table_cannot_tell() -> None:
    """Twelve places in a turn: a wave six times a turn lies at its zeros, and is not in it."""
    a = np.arange(12) * 2.0 * math.pi / 12
    law = Law("rotor_torque", ("rotor_angle",), (tuple(a),), tuple(0.1 * np.cos(6.0 * a)))
    assert formula(law, np.zeros(12)) is None
    law = Law("rotor_torque", ("rotor_angle",), (tuple(a),), tuple(0.1 * np.cos(2.0 * a)))
    assert formula(law, np.zeros(12)) == "0.1 N m cos(2a)"
