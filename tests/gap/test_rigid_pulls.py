"""Rigid drives: what a sheet holds, what pulls on it cost, what speaks for an effect."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from rigid_machines import ROTARY, motion, recorded
from scipy.optimize import minimize
from scipy.signal import lfilter

from ecyl_ros.effects import gravity_on_arm, load_inertia_error
from ecyl_ros.effects.catalogue import RIGID
from ecyl_ros.gap.rigid.balance import Balance
from ecyl_ros.gap.rigid.certainty import Certainty
from ecyl_ros.gap.rigid.contest import won_by
from ecyl_ros.gap.rigid.diagnose import judged
from ecyl_ros.gap.rigid.floor import white_part
from ecyl_ros.gap.rigid.lower import _on_sheet
from ecyl_ros.gap.rigid.motion import motion_of
from ecyl_ros.gap.rigid.null import Null
from ecyl_ros.gap.rigid.pulls import cheapest
from ecyl_ros.gap.rigid.sets import Sets
from ecyl_ros.gap.rigid.terms import Catalogue

M = motion(1.5)


@pytest.mark.parametrize("seed", range(5))
def test_pulls_are_as_cheap_as_one_structure_allows(seed: int) -> None:
    """The least sum of squared pulls within an effort of that size, as SciPy finds it; a
    coefficient that nothing is known of adapts."""
    rng = np.random.default_rng(seed)
    columns = rng.normal(size=(400, 4)) @ rng.normal(size=(4, 4))
    power = columns.T @ columns / 400.0
    prior = np.array([2.0, 5.0, 0.0, 1.0])
    found = rng.normal(size=4)
    structure = 0.5 * np.sqrt(np.mean((columns[:, [0, 1, 3]] @ found[[0, 1, 3]]) ** 2))
    made = cheapest(prior * found, prior, power, structure)

    def off(x: np.ndarray) -> float:
        return structure**2 - float((x - found) @ power @ (x - found))

    best = minimize(
        lambda x: float(np.sum((prior * x) ** 2)),
        found,
        constraints={"type": "ineq", "fun": off},
        options={"ftol": 1e-12, "maxiter": 500},
    )
    assert np.sum(made**2) == pytest.approx(best.fun, rel=1e-3, abs=1e-9)
    assert np.allclose(cheapest(prior * found, prior, power, 0.0), prior * found)
    assert not cheapest(prior * found, prior, power, 1e6).any()


def test_one_constant_gives_way_by_what_the_structure_bends() -> None:
    """Of one constant it is the pull less the structure over the size of its column."""
    made = cheapest(np.array([6.0]), np.array([2.0]), np.array([[4.0]]), 1.0)
    assert made == pytest.approx([6.0 - 2.0 * 1.0 / 2.0])


def _balance(effort: np.ndarray, noise: float = 0.02) -> tuple[Balance, Catalogue]:
    moved = motion_of(recorded(M, effort, ROTARY, noise, 1e-5), ROTARY, "r")
    catalogue = Catalogue(moved, ROTARY)
    return Balance(moved, catalogue.nominal(), catalogue.model), catalogue


def test_white_noise_through_the_filter_is_found() -> None:
    """Within 10 %."""
    balance, _ = _balance(0.02 * M.a)
    white = balance.motion.filtered(np.random.default_rng(2).normal(size=M.t.size))
    left = dataclasses.replace(balance.fit([]), residual=white)
    assert white_part(balance, left) == pytest.approx(float(np.std(white)), rel=0.1)


@pytest.mark.parametrize("seed", range(20, 30))
def test_what_changes_slowly_is_no_white_noise(seed: int) -> None:
    """Of three short stretches of an effort that follows itself (0.7 from one compared sample to
    the next) a part is white, however scattered their spectra are."""
    balance, _ = _balance(0.02 * M.a)
    rng = np.random.default_rng(seed)
    slow = lfilter([1.0], [1.0, -0.7], rng.normal(size=balance.usable.size))
    rows = np.concatenate([np.arange(30) + begin for begin in (100, 160, 220)])
    balance.usable = np.isin(np.arange(slow.size), rows)
    left = dataclasses.replace(balance.fit([]), residual=slow)
    assert white_part(balance, left) < 0.9 * float(np.std(slow[rows]))


@pytest.mark.parametrize("both", [True, False])
def test_an_effect_acts_if_it_is_missed_beside_its_rival(both: bool) -> None:
    """Where gravity and a spring act, the spring alone leaves as little as gravity alone: that says
    nothing against gravity. Where the spring alone acts, it does."""
    extra = 0.3 * np.sin(M.q) * both
    twist = M.q - M.q.mean()
    extra = extra + 0.3 * np.std(np.sin(M.q)) / np.std(twist) * twist
    balance, catalogue = _balance(0.02 * M.a + extra)
    sets = Sets(Null(balance, catalogue), 0.01, ())
    gravity = gravity_on_arm.term(catalogue.along)
    spring = RIGID["spring_load"].term(catalogue.along)
    contest = won_by([gravity], sets, sets.fit([]), [], {})
    certainty = Certainty(sets.null, contest, balance.judged, 0.01)
    rival = sets.fit([spring])
    beside = certainty._behind_both(rival, spring, set())
    if both:
        assert certainty._behind(rival, 0.0) < 10.0 < beside
    else:
        assert beside < 0.0


@pytest.mark.parametrize(
    ("share", "on_sheet"), [(1.0, True), (1.15, True), (0.5, False), (2.0, False)]
)
def test_an_inertia_that_is_let_go_tells_whether_the_sheet_holds_it(share, on_sheet) -> None:
    """Within a tolerance of 20 % it does; half and twice are off it, whatever a set has named."""
    machine = dataclasses.replace(
        ROTARY, inertia=0.02 * share, coulomb=0.2, tolerances={"load.inertia": 0.2}
    )
    effort = 0.02 * M.a + 0.2 * np.sign(M.v)
    moved = motion_of(recorded(M, effort, machine, 0.02, 1e-5), machine, "r")
    found = judged(moved, machine, (), "r", lambda share: None)
    own = load_inertia_error.term(found.catalogue.along)
    fit = found.balance.fit([own, *found.catalogue.smooth()], found.balance.usable)
    assert _on_sheet(found, own, fit) == on_sheet
