"""Which sets of variables, at which ports, a description tries and takes."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
from guess_samples import guess

from ecyl_ros.gap.describe.chance import LEVEL
from ecyl_ros.gap.describe.choose import Choice, standing
from ecyl_ros.gap.describe.describe import _at_other_ports, _by_chance, _Candidate, _in_order
from ecyl_ros.gap.describe.missing import TORQUE, VOLTAGE
from ecyl_ros.gap.split import STRETCH_S, stretch_of


def test_the_smaller_set_stands_unless_the_larger_predicts_better_stretch_by_stretch():
    """A lead on one stretch alone is chance; the same lead on all of them is not."""
    rng = np.random.default_rng(5)
    level = 40.0 * np.exp(0.05 * rng.standard_normal(16))
    one_better = level.copy()
    one_better[3] *= 0.01
    small, large = guess(("speed",), level, 9.0), guess(("speed", "time"), one_better, 9.0)
    assert standing([small, large]) is small
    large = guess(("speed", "time"), 0.5 * level, 9.0)
    assert standing([small, large]) is large


def test_sets_with_and_without_what_the_loop_answers_with_are_tried_side_by_side():
    """Of each number of variables the two that predict best, of either sort, if well enough."""
    errors = {
        ("current",): 1.0,
        ("torque",): 1.1,
        ("position",): 3.0,
        ("speed",): 4.0,
        ("time",): 5.0,
        ("heat",): 50.0,
        ("current", "speed"): 0.5,
        ("position", "speed"): 0.9,
    }
    guesses = [guess(of, np.full(9, 40.0 * error), 9.0) for of, error in errors.items()]
    alone = guess((), np.full(9, 4000.0), 0.0).found
    best = guesses[2]
    near = Choice(best, tuple(one for one in guesses if one is not best), alone).near
    assert [one.of for one in near] == [
        ("position",),
        ("speed",),
        ("current",),
        ("torque",),
        ("position", "speed"),
        ("current", "speed"),
    ]


def test_a_balance_at_its_noise_misses_nothing():
    """A law that predicts noise that is smaller than said, and not by chance, is none."""
    sheet, law = guess((), np.full(9, 36.0), 0.0), guess(("time",), np.full(9, 16.0), 9.0)
    choice = Choice(law, (), sheet.found)
    assert law.found.error < 0.5 * sheet.found.error < 0.5
    assert choice.by_chance(law) < LEVEL
    assert choice.near == []


def test_ports_that_account_for_most_do_not_crowd_out_what_begins_nearest():
    """Of each number of variables one that accounts for most, and one that begins nearest, in
    turn."""
    none: Any = None

    def candidate(port: str, of: tuple[str, ...], cost: float) -> _Candidate:
        begun: Any = SimpleNamespace(fitted=cost)
        return _Candidate(guess(of, np.full(9, 40.0), 9.0), port, none, none, begun)

    candidates = [
        candidate("rotor_torque", ("time",), 3.0),
        candidate("current_error", ("time",), 20.0),
        candidate("current_error", ("heat",), 21.0),
        candidate("load_torque", ("time",), 2.0),
        candidate("load_torque", ("heat", "time"), 1.0),
    ]
    ordered = _in_order(candidates, {TORQUE, VOLTAGE})
    assert [(one.port, *one.guess.of) for one in ordered] == [
        ("current_error", "time"),
        ("load_torque", "time"),
        ("current_error", "heat"),
        ("rotor_torque", "time"),
        ("load_torque", "heat", "time"),
    ]


def test_what_rattling_flanks_hide_in_the_loop_the_balance_tells():
    """A law that leaves more in the loop of every other stretch is not by chance where its balance
    shows it in all of them, and is where the balance does not."""
    none: Any = None
    time_s = np.arange(0.0, 16.0 * STRETCH_S, 0.025 * STRETCH_S)
    all_rows = np.ones(len(time_s), dtype=bool)
    fitter: Any = SimpleNamespace(
        rows=all_rows, held=~all_rows, perfect=1.0, replay=SimpleNamespace(time_s=time_s)
    )
    gap = 3.0 * np.random.default_rng(7).standard_normal((1, len(time_s)))
    null: Any = SimpleNamespace(gap=gap)
    played: Any = SimpleNamespace(unseen=np.where(stretch_of(time_s) % 2, 2.0, 0.5) * gap)

    def chance(after: float) -> float:
        sheet, law = (
            guess(of, np.full(16, one), 9.0) for of, one in (((), 400.0), (("time",), after))
        )
        choice = Choice(law, (sheet,), sheet.found)
        chosen = _Candidate(law, "rotor_torque", choice, none, none)
        return _by_chance(fitter, null, played, chosen, [chosen])

    assert chance(40.0) < LEVEL
    assert chance(400.0) > LEVEL


def test_a_law_that_leaves_more_than_noise_is_finished_at_the_other_ports_it_comes_near_at():
    """A torque on the rotor that two steps take for one on the load goes on beside it; a law of
    other variables does not, nor one that is far off."""
    none: Any = None
    of_current, of_speed = (guess((of,), np.ones(16), 9.0) for of in ("current", "speed"))
    choice = Choice(of_current, (of_speed,), of_current.found)

    def rough(law: Any, port: str, left: float) -> Any:
        played: Any = SimpleNamespace(fitted=left)
        return played, _Candidate(law, port, choice, none, none)

    first = rough(of_current, "load_torque", 2.3)
    near = rough(of_current, "rotor_torque", 2.4)
    others = [rough(of_speed, "rotor_torque", 2.4), rough(of_current, "rotor_friction", 40.0)]
    assert _at_other_ports([first, near, *others], *first) == [near]
