"""Followers, known by reference and position alone, against lag and play put in by hand."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from ecyl_ros.drive.rigid.machine import Machine
from ecyl_ros.errors import InputError
from ecyl_ros.gap.diagnose import diagnose
from ecyl_ros.gap.follower import resolution
from ecyl_ros.gap.report.page import report_html
from ecyl_ros.gap.report.terminal import summary
from ecyl_ros.gap.report.verdict import sentence
from ecyl_ros.gap.rigid.motion import motion_of
from ecyl_ros.recording.signals import Recording

MACHINE = Machine(kind="follower", output="rotary")
STEP = 2.0 * np.pi / 4096.0


def _followed(lag_s: float, width: float, rate: float = 50.0, offset: float = 0.0) -> Recording:
    """A command through a lag and a play, at 10 kHz, then sampled and rounded to the encoder."""
    fine = np.arange(0.0, 60.0, 1e-4)

    def command(t):
        t = np.maximum(t, 0.0)
        return 0.3 * np.sin(1.1 * t) + 0.1 * np.sin(2.9 * t + 1.0)

    state, out = command(fine[:1])[0], np.empty(fine.size)
    for index, value in enumerate(command(fine - lag_s).tolist()):
        state = min(max(state, value - 0.5 * width), value + 0.5 * width)
        out[index] = state
    rows = np.round(np.arange(0.0, 59.9, 1.0 / rate) * 1e4).astype(int)
    rng = np.random.default_rng(5)
    position = out[rows] + offset + 0.3 * STEP * rng.normal(size=rows.size)
    return Recording(
        stamp_ns=np.round(fine[rows] * 1e9).astype(np.int64),
        reference_position_rad=command(fine[rows]),
        rotor_position_rad=np.round(position / STEP) * STEP,
    )


def _measured(result) -> dict:
    return {one.name: one for one in result.measured}


@pytest.mark.parametrize(("lag_s", "width"), [(0.08, 0.03), (0.03, 0.01), (0.2, 0.06)])
def test_lag_and_play_come_out_as_put_in(lag_s, width) -> None:
    """Lag, width and offset lie within their intervals, which are narrow; no cause is named."""
    result = diagnose(_followed(lag_s, width, offset=0.02), MACHINE)
    found = _measured(result)
    for name, truth, near in (
        ("lag_s", lag_s, 0.005),
        ("dead_band_rad", width, STEP),
        ("offset_rad", 0.02, STEP),
    ):
        one = found[name]
        assert one.low <= truth <= one.high
        assert one.value == pytest.approx(truth, abs=near) and one.high - one.low < 4.0 * near
    assert found["resolution_rad"].value == pytest.approx(STEP, rel=1e-4)
    assert result.verdict == "unexplained" and not result.causes and result.block is None
    assert "sheet" not in sentence(result)  # it has none


@pytest.mark.parametrize("width", [0.0, 0.1])
def test_an_axis_that_is_slower_than_its_reference_jumps_has_no_dead_band_by_that(width) -> None:
    """A square wave, an axis of 1 rad/s at the most: it stops where it is asked to be, or half of a
    true dead band short of that, and the width is told from there."""
    rate = 100.0
    time_s = np.arange(0.0, 40.0, 1.0 / rate)
    asked = np.where(time_s % 4.0 < 2.0, 0.4, -0.4)
    state, out = 0.0, np.empty(time_s.size)
    for index, value in enumerate(asked.tolist()):
        aim = min(max(state, value - 0.5 * width), value + 0.5 * width)
        state += min(max(aim - state, -1.0 / rate), 1.0 / rate)
        out[index] = state
    recording = Recording(
        stamp_ns=np.round(time_s * 1e9).astype(np.int64),
        reference_position_rad=asked,
        rotor_position_rad=np.round(out / STEP) * STEP,
    )
    result = diagnose(recording, MACHINE)
    found = _measured(result)["dead_band_rad"]
    assert found.low <= width <= found.high < width + 0.02
    assert any("where the reference stands" in note for note in result.notes)


def _moves(time_s):
    """Smooth moves between places at random, of 1.5 s each."""
    places = np.concatenate([[0.0], np.random.default_rng(2).uniform(-0.6, 0.6, 60)])
    time_s = np.maximum(time_s, 0.0) / 1.5
    move = time_s.astype(int)
    share = np.clip(1.25 * (time_s - move), 0.0, 1.0)
    share = share**3 * (10.0 - 15.0 * share + 6.0 * share**2)
    return places[move] + (places[move + 1] - places[move]) * share


def _servo(command, *, friction=0.3, integral=0.0, gravity=0.0, error=lambda position: 0.0):
    """A servo (PD or PID, an inertia with Coulomb friction, an arm's weight) read by an encoder."""
    step = 1e-3
    fine = np.arange(0.0, 60.0, step)
    wanted, position, speed, summed = command(fine), 0.0, 0.0, 0.0
    out = np.empty(fine.size)
    for index, value in enumerate(wanted.tolist()):
        summed += (value - position) * step
        torque = 60.0 * (value - position) - 6.0 * speed + integral * summed
        torque += gravity * np.sin(position)
        if abs(speed) < 1e-3 and abs(torque) <= friction:
            speed = 0.0
        else:
            way = np.sign(speed) if abs(speed) >= 1e-3 else np.sign(torque)
            speed += (torque - friction * way) / 0.05 * step
        position += speed * step
        out[index] = position + error(position)
    rows = np.arange(0, fine.size, 20)
    read = out[rows] + 0.3 * STEP * np.random.default_rng(5).normal(size=rows.size)
    return Recording(
        stamp_ns=np.round(fine[rows] * 1e9).astype(np.int64),
        reference_position_rad=wanted[rows],
        rotor_position_rad=np.round(read / STEP) * STEP,
    )


def test_an_error_of_the_position_is_described_as_one_of_it() -> None:
    """A reading that is off by 12 mrad eight times a turn comes back as that curve over position,
    and closes the gap that lag and dead band leave."""
    result = diagnose(
        _servo(_moves, friction=0.0, error=lambda x: 0.012 * np.sin(8.0 * x)), MACHINE
    )
    assert result.verdict == "described" and not result.causes and result.block is None
    law = result.law
    assert law.law.port == "following_error" and law.law.of == ("position",)
    assert law.shrink > 0.95 and law.law.unit == "rad" and law.law.units == ("rad",)
    places = np.array(law.law.at[0])[law.seen]
    found = np.array(law.law.values)[law.seen]
    truth = 0.012 * np.sin(8.0 * places)
    off = (found - found.mean()) - (truth - truth.mean())
    assert np.sqrt(np.mean(off**2)) < 0.1 * np.std(truth)
    assert "a departure of the output from its reference" in sentence(result)
    assert "following_error" in report_html(result)


def test_a_weight_is_the_slope_that_it_gives_the_error() -> None:
    """An arm of 2 N m on a loop of 60 N m/rad departs by 1/30 rad per rad, within a tenth."""
    result = diagnose(_servo(_moves, friction=0.3, gravity=2.0), MACHINE)
    assert result.verdict == "described" and "position" in result.law.law.of
    places, values = result.law.points[0], result.law.points[-1]
    assert np.polyfit(places, values, 1)[0] == pytest.approx(2.0 / 60.0, rel=0.1)


def _sine(time_s):
    return 0.4 * np.sin(1.3 * np.maximum(time_s, 0.0))


@pytest.mark.parametrize("command", [_moves, _sine])
@pytest.mark.parametrize("kind", [{}, {"integral": 60.0}, {"friction": 0.0}])
def test_no_loop_becomes_a_law(command, kind) -> None:
    """What friction, an integrator and the loop itself leave is no law."""
    result = diagnose(_servo(command, **kind), MACHINE)
    assert result.verdict == "unexplained" and result.law is None


def test_a_mere_lag_proves_no_dead_band() -> None:
    """Without play the notes say that none is proven."""
    result = diagnose(_followed(0.08, 0.0), MACHINE)
    assert _measured(result)["dead_band_rad"].low <= STEP
    assert any("no dead band is proven" in note for note in result.notes)


def test_a_perfect_follower_has_no_gap() -> None:
    """Position equals reference to the resolution: no gap."""
    assert diagnose(_followed(0.0, 0.0), MACHINE).verdict == "no_gap"


def test_what_fifty_hertz_cannot_show_is_said() -> None:
    """Notes and page name the limits: half the rate, and what an encoder at the output hides."""
    result = diagnose(_followed(0.08, 0.03), MACHINE)
    assert _measured(result)["highest_frequency_hz"].value == pytest.approx(25.0, rel=0.01)
    text = " ".join(result.notes)
    for word in ("inertia", "cogging", "stiffness", "backlash between motor and encoder"):
        assert word in text
    assert "dead band" in summary(result) and "Lag" in report_html(result)


def test_the_resolution_is_the_encoders_step() -> None:
    """Rounded, resampled or stated: the step; of a fine signal: none."""
    rng = np.random.default_rng(0)
    smooth = np.cumsum(rng.normal(size=4000)) * 1e-3
    stepped = np.round(smooth / STEP) * STEP
    assert resolution(stepped, 0.0) == pytest.approx(STEP, rel=1e-4)
    held = np.repeat(stepped[::8], 8)
    between = np.interp(np.arange(0.0, 3999.0, 1.003), np.arange(4000.0), held)
    assert resolution(between, 0.0) == pytest.approx(STEP, rel=1e-3)
    assert resolution(smooth, 0.0) == 0.0 and resolution(smooth, 1e-3) == 1e-3


def test_a_follower_without_reference_is_refused() -> None:
    """No reference: the field is named."""
    good = _followed(0.08, 0.03)
    bad = Recording(stamp_ns=good.stamp_ns, rotor_position_rad=good.rotor_position_rad)
    with pytest.raises(InputError, match=r"x.csv: reference_position in rad is missing"):
        diagnose(bad, MACHINE, source="x.csv")
    still = Recording(
        stamp_ns=good.stamp_ns,
        rotor_position_rad=good.rotor_position_rad,
        reference_position_rad=np.zeros(len(good)),
    )
    with pytest.raises(InputError, match=r"the reference moves by less than 4 steps"):
        diagnose(still, MACHINE)


def test_the_step_that_a_map_states_is_that_of_the_position() -> None:
    """Positions that were put on an even grid keep no equal values: the map's step counts, unless
    the drive file states one; of a rigid drive it is the least noise of the position."""
    given = _followed(0.08, 0.03)
    smooth = given.rotor_position_rad + 1e-6 * np.random.default_rng(2).normal(size=len(given))
    mapped = dataclasses.replace(
        given, rotor_position_rad=smooth, resolution={"rotor_position_rad": STEP}
    )
    assert _measured(diagnose(mapped, MACHINE))["resolution_rad"].value == STEP
    stated = dataclasses.replace(MACHINE, position_resolution=2.0 * STEP)
    assert _measured(diagnose(mapped, stated))["resolution_rad"].value == 2.0 * STEP
    rigid = Machine(kind="rigid", output="rotary")
    assert motion_of(mapped, rigid, "r").position_noise >= STEP / np.sqrt(12.0)
