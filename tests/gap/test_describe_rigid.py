"""Rigid drives whose missing effort has no name: the law that describes it, against the truth."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from rigid_machines import LINEAR, ROTARY, Motion, motion, recorded

import ecyl_ros as ec
from ecyl_ros.drive.law import law_from_flat, law_to_flat
from ecyl_ros.drive.rigid.machine_file import load_machine
from ecyl_ros.gap.describe.description import Description
from ecyl_ros.gap.describe.guess import Trial
from ecyl_ros.gap.describe.measured_motion import Decimated, MeasuredMotion, answers
from ecyl_ros.gap.describe.trials import singles
from ecyl_ros.gap.diagnose import diagnose
from ecyl_ros.gap.diagnosis import Diagnosis
from ecyl_ros.gap.report.page import report_html
from ecyl_ros.gap.report.terminal import summary

MOTION = motion(0.1)
WIDE = motion(6.0)


def found(asked: Callable[[Motion], np.ndarray], noise: float = 0.3) -> Diagnosis:
    """Of a mass of 20 kg that needs an effort besides, N."""
    return diagnose(recorded(MOTION, 20.0 * MOTION.a + asked(MOTION), LINEAR, noise, 1e-6), LINEAR)


def law_of(diagnosis: Diagnosis) -> Description:
    """Where there is one, and no cause beside it."""
    assert diagnosis.verdict == "described" and diagnosis.law is not None
    assert not diagnosis.causes
    return diagnosis.law


def inside(law: Description, true: Callable[[np.ndarray], np.ndarray]) -> float:
    """Share of the visited places whose 95 % band, or a thirtieth of the law, holds the truth."""
    places, values = np.array(law.law.at[0]), np.array(law.law.values)
    off = np.abs(values - true(places))
    near = off <= np.maximum(law.half, np.ptp(values) / 30.0)
    return float(np.mean(near[law.seen]))


def bump(q: np.ndarray) -> np.ndarray:
    """A resistance at one place, N."""
    return 8.0 * np.exp(-(((q - 0.03) / 0.015) ** 2))


def notch(q: np.ndarray) -> np.ndarray:
    """A torque at one place of the turn, N m."""
    return 0.5 * np.exp(3.0 * (np.cos(q - 1.0) - 1.0)) * np.sin(q)


def test_a_resistance_at_one_place_is_a_law_of_position() -> None:
    """What drags against positive motion at a place, whichever way it moves, is told by its curve,
    with the sign of what drives, and most of the gap is gone on held-out stretches."""
    diagnosis = found(lambda m: bump(m.q))
    law = law_of(diagnosis)
    assert law.law.port == "load_torque" and law.law.of == ("position",)
    assert law.law.unit == "N" and law.law.units == ("m",)
    assert inside(law, lambda q: -bump(q)) > 0.9
    assert law.shrink > 0.9 and diagnosis.block == "load"
    # The nearest of the named effects is told, drawn over the same places, and far from it.
    near = law.resembles
    assert near is not None and near.curve is not None and near.misfit > 5.0 * near.law_misfit
    assert law.law.at[0][0] <= near.curve[0].min() and near.curve[0].max() <= law.law.at[0][-1]
    assert np.abs(near.curve[1]).max() < 4.0
    assert "the nearest named effect, would give there" in report_html(diagnosis)
    # Position and speed are replayed with it.
    assert [one.name for one in diagnosis.signals] == ["force", "position", "speed"]
    assert all(one.after < 0.3 * one.gap for one in diagnosis.signals)
    assert diagnosis.series.recorded.shape == diagnosis.series.after.shape
    assert diagnosis.series.recorded.shape[0] == 3


def test_a_drag_at_one_speed_is_a_friction_of_speed() -> None:
    """A level against the motion that is there at one speed alone."""

    def drag(v: np.ndarray) -> np.ndarray:
        return 6.0 * np.exp(-(((v - 0.15) / 0.05) ** 2))

    law = law_of(found(lambda m: drag(m.v)))
    assert law.law.of == ("speed",) and law.law.units == ("m/s",)
    sign = 1.0 if law.law.of_friction else -1.0
    assert inside(law, lambda v: sign * drag(v) * np.where(v < 0.0, -sign, 1.0)) > 0.9


def test_what_a_law_closes_is_told_of_the_rows_that_the_gap_is_told_of() -> None:
    """A bump beside what sticks near reversals, where a law is unknown: the figures say what the
    residual that is shown comes to, on all rows that are judged, before and after."""
    m = MOTION
    stuck = 6.0 * np.sign(m.v) * (np.abs(m.v) < 0.02)  # where a coarse encoder tells no speed
    effort = 20.0 * m.a + bump(m.q) + stuck
    diagnosis = diagnose(recorded(m, effort, LINEAR, 0.3, 1e-4), LINEAR)
    assert diagnosis.verdict == "described"
    gap, series = diagnosis.signals[0], diagnosis.series
    rows = series.held_out & series.usable
    for told, simulated in ((gap.gap, series.before[0]), (gap.after, series.after[0])):
        left = (series.recorded[0] - simulated)[rows]
        assert told == pytest.approx(float(np.sqrt(np.mean(left**2))), rel=0.02)


def test_a_law_that_is_only_part_of_what_is_missing_is_a_note() -> None:
    """A bump beside an effort that bends with the acceleration, which no law depends on: no law
    is described, but the note names position and how much it removes, as the bump's power says."""
    m = MOTION
    bent = np.tanh(3.0 * m.a / np.std(m.a))
    bent -= m.a * (bent @ m.a) / (m.a @ m.a)  # what no inertia accounts for
    bent *= 0.5 / np.std(bent)
    diagnosis = found(lambda m: bump(m.q) + bent)
    assert diagnosis.verdict == "unexplained" and diagnosis.law is None
    (note,) = (one for one in diagnosis.notes if one.startswith("closest law"))
    assert "a force on the load that depends on position removes" in note
    told = float(note.split(" removes ")[1].split(" %")[0]) / 100.0
    whole, part = np.hypot(np.std(bump(m.q)), 0.5), 0.5
    assert told == pytest.approx(1.0 - part / whole, abs=0.08)


def test_a_spring_that_hardens_is_told_by_its_formula() -> None:
    """A force with the cube of the position comes out as that, its factor within 2 %."""
    law = law_of(found(lambda m: 8e4 * m.q**3))
    assert law.formula is not None
    size, *rest = law.formula.split()
    assert float(size) == pytest.approx(-8e4, rel=0.02) and " ".join(rest) == "N/m^3 x^3"


def test_an_output_that_turns_has_a_law_of_its_angle() -> None:
    """A torque at one place of the turn, over several turns, is periodic in the angle."""

    m = WIDE
    law = law_of(diagnose(recorded(m, 0.02 * m.a + notch(m.q), ROTARY, 0.01, 1e-5), ROTARY))
    assert law.law.port == "rotor_torque" and law.law.of == ("rotor_angle",)
    assert law.law.unit == "N m" and inside(law, lambda q: -notch(q)) > 0.9


def test_a_wave_finer_than_the_table_of_a_turn_comes_back_at_its_size() -> None:
    """Forty times a turn with an overtone, at speeds at which the effort's filter takes from it:
    within 5 %, and the file's table repeats itself as often."""
    m = WIDE
    wave = 0.2 * np.sin(40.0 * m.q + 0.4) + 0.06 * np.sin(80.0 * m.q)
    without = ("cogging_torque", "torque_ripple", "periodic_disturbance")
    given = recorded(m, 0.02 * m.a + wave, ROTARY, 0.02, 1e-4)
    law = law_of(diagnose(given, ROTARY, without=without))
    assert law.law.of == ("rotor_angle",) and law.words.endswith("40 times a turn")
    assert law.law.periods == pytest.approx((math.tau / 40.0,))
    (places,), values = law.law.at, np.array(law.law.values)
    turned = 40.0 * np.array(places)
    truth = -0.2 * np.sin(turned + 0.4) - 0.06 * np.sin(2.0 * turned)
    assert np.abs(values - truth).max() < 0.05 * 0.2
    assert law.formula is not None and "cos(40a)" in law.formula and "sin(80a)" in law.formula
    assert law_from_flat(law_to_flat(law.law), "file") == replace(
        law.law, effort_unit="", variable_units=()
    )


@pytest.mark.parametrize("seed", range(3))
def test_an_effort_that_wanders_is_no_law(seed: int) -> None:
    """What depends on nothing that was recorded is not described, and a healthy drive neither."""
    course = np.random.default_rng(seed).normal(size=21)
    wandering = found(lambda m: 5.0 * np.interp(m.t, np.arange(21.0), course))
    assert wandering.verdict != "described"
    assert found(lambda m: 0.0 * m.q).verdict == "no_gap"


@pytest.mark.parametrize(("asked", "told"), [("rests", False), ("moves", True), (None, True)])
def test_a_speed_that_the_loop_answers_with_is_no_variable_of_a_law(asked, told) -> None:
    """A resting reference, and a speed that cogging disturbs: the loop's effort is its own law of
    that speed. A reference that moves as the drive does, and one that is not known, deny nothing.
    """
    cogs = 6.0 + 2.0 * np.sin(36.0 * WIDE.t)
    references = {
        "rests": np.full(WIDE.t.size, 6.0),
        "moves": cogs,
        None: np.full(WIDE.t.size, np.nan),
    }
    course = SimpleNamespace(
        velocity=cogs,
        reference_velocity=references[asked],
        reference_position=np.full(WIDE.t.size, np.nan),
        rate_hz=1.0 / float(WIDE.t[1]),
    )
    rows = np.arange(WIDE.t.size)
    position = 6.0 * WIDE.t
    moved = MeasuredMotion(
        WIDE.t,
        position,
        cogs,
        rows >= 0,
        "rotor_angle",
        0.5,
        Decimated(float(WIDE.t[1])),
        answers=answers(course, rows),
    )
    assert (Trial(("speed",)) in singles("torque", moved)) is told
    assert Trial(("rotor_angle",)) in singles("torque", moved)


@pytest.mark.parametrize("back", [True, False])
def test_the_way_since_a_reversal_is_asked_for_where_there_are_reversals(back: bool) -> None:
    """Of a drive that goes one way alone that way is time, or its position, by another name."""
    t = np.arange(2000) / 200.0
    speed = np.sin(math.tau * t) if back else 1.0 + 0.5 * np.sin(math.tau * t)
    seen = MeasuredMotion(
        t, np.cumsum(speed) / 200.0, speed, speed != 0.0, "position", 0.5, Decimated(1 / 200.0)
    )
    assert (Trial(("travel",)) in singles("torque", seen)) == back


def test_report_json_and_summary_tell_the_law() -> None:
    """Units in all three."""
    diagnosis = found(lambda m: bump(m.q))
    assert "a force on the load that depends on position" in " ".join(summary(diagnosis).split())
    assert "Added to the model it removes" in " ".join(summary(diagnosis).split())
    page = report_html(diagnosis)
    assert "position, m" in page and "value, N" in page
    data = json.loads(json.dumps(diagnosis.as_json()))["law"]
    assert data["unit"] == "N" and data["units"] == ["m"] and len(data["table"]["at"]) == 48


@pytest.mark.parametrize("output", ["linear", "rotary"])
def test_the_twin_plays_the_law(tmp_path, output: str) -> None:
    """The drive file with the law in it has no gap to the recording that it came from, and none
    that a fault would make to one of another motion."""
    linear = output == "linear"
    mass, key, signal, off = (
        (20.0, "mass", "force", bump) if linear else (0.02, "inertia", "torque", notch)
    )
    of, noise, step = (LINEAR, 0.3, 1e-6) if linear else (ROTARY, 0.01, 1e-5)
    drive, twin = tmp_path / "axis.yaml", tmp_path / "twin.yaml"
    drive.write_text(
        f"/**:\n  ros__parameters:\n    drive: {{kind: rigid, output: {output}}}\n"
        f"    actuation: {{signal: {signal}}}\n    load: {{{key}: {mass}}}\n"
    )
    first, other = (MOTION, motion(0.08)) if linear else (WIDE, motion(5.0))
    run = recorded(first, mass * first.a + off(first.q), of, noise, step)
    described = ec.diagnose(run, drive)
    described.write_drive(twin)
    told = {
        one.parameter: one.value for one in described.sheet
    }  # beside the law, as the twin has it
    assert told[f"load.{key}"] == pytest.approx(load_machine(twin).inertia, rel=1e-6)
    assert ec.diagnose(run, twin).verdict in ("no_gap", "within_sheet")
    again = recorded(other, mass * other.a + off(other.q), of, noise, step)
    assert ec.diagnose(again, drive).verdict not in ("no_gap", "within_sheet")
    assert ec.diagnose(again, twin).verdict in ("no_gap", "within_sheet")
