"""What a gap goes with, and on which side of the clearance missing torque acts."""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest
from other_make import DRIVE, recorded, replayed
from sheets import exact

from ecyl_ros.gap.compete.competition import Competition
from ecyl_ros.gap.fit.fit import Fitter
from ecyl_ros.gap.locate.block import unnamed_block
from ecyl_ros.gap.locate.injection import acts_on_load
from ecyl_ros.gap.locate.locate import by_port
from ecyl_ros.gap.locate.signature import (
    goes_along_stroke,
    goes_with_current,
    goes_with_encoder,
    limit_reached,
)
from ecyl_ros.gap.replay.replay import Replay
from ecyl_ros.gap.split import held_out


def without(*signals: str) -> Replay:
    """The replay of a load that drags, with some signals not recorded."""
    recording = recorded({"load_coulomb_friction": {"coulomb_nm": 0.1}})
    nothing = {name: np.full(len(recording), np.nan) for name in signals}
    return Replay(dataclasses.replace(recording, **nothing), DRIVE, "recording")


def said(replay: Replay) -> str | None:
    """The block said where no effect at all competes."""
    nominal = Fitter(replay, held_out(replay.time_s)).nominal
    nothing = Competition(nominal, nominal, (), nominal, (), {})
    return unnamed_block(nothing, by_port(replay), replay)


@pytest.mark.parametrize(
    ("effects", "block"),
    [
        ({"rotor_coulomb_friction": {"coulomb_nm": 0.2}}, "motor_mechanical"),
        ({"rotor_viscous_friction": {"viscous_nm_s_per_rad": 0.01}}, "motor_mechanical"),
        ({"x_random_torque": {"torque_nm": 0.05, "corner_rad_s": 100.0}}, "motor_mechanical"),
        ({"constant_load": {"force_n": 150.0}}, "load"),
        ({"load_viscous_friction": {"viscous_nm_s_per_rad": 0.01}}, "load"),
        ({"load_inertia_error": {"inertia_kg_m2": 0.0009}}, "load"),
        ({"x_load_dependent_friction": {"coefficient": 0.2}}, "load"),
        ({"torque_constant_error": {"torque_constant_nm_per_a": 0.85}}, "motor_electrical"),
        ({"resistance_error": {"resistance_ohm": 1.1}}, "motor_electrical"),
        ({"x_current_sensor_gain": {"gain_error": 0.12}}, "sensor"),
        ({"current_sensor_offset": {"offset_a": 0.15}}, "sensor"),
        ({"encoder_eccentricity": {"amplitude_rad": 0.004}}, "sensor"),
        ({"x_encoder_second_harmonic": {"amplitude_rad": 0.004}}, "sensor"),
        ({"lead_error": {"lead_m": 0.0198}}, "transmission"),
        (
            {"transmission_error": {"amplitude_rad": 0.02, "periods_per_screw_rev": 1.0}},
            "transmission",
        ),
        ({"backlash_error": {"backlash_rad": 0.009}}, "transmission"),
        ({"measurement_delay": {"delay_s": 1.5e-4}}, "timing"),
        ({"current_limit": {"current_a": 1.1}}, "controller"),
        ({"voltage_limit": {"voltage_v": 3.2}}, "controller"),
    ],
    ids=lambda value: value if isinstance(value, str) else next(iter(value)),
)
def test_the_block_is_right_with_no_effect_at_hand(effects, block) -> None:
    """What is measured on another make of machine names the true block without any fit."""
    assert said(replayed(effects)) == block


def test_what_pushes_back_along_the_stroke_is_told_from_what_else_acts() -> None:
    """A spring that hardens and a stop at one end rise along it; cogging, drag and inertia under
    more than one sine do not."""
    time = np.linspace(0.0, 6.0, 6001)
    angle = 4.0 * np.sin(4.0 * time) + 2.5 * np.sin(11.0 * time + 1.0)
    speed, acceleration = np.gradient(angle, time), np.gradient(np.gradient(angle, time), time)
    noise = np.random.default_rng(3).normal(0.0, 0.02, time.size)

    def along(torque: np.ndarray) -> float:
        return goes_along_stroke(SimpleNamespace(torque_nm=torque + noise, rotor_angle_rad=angle))

    assert along(-1e-2 * angle**3) > 0.95
    assert along(-0.5 * np.maximum(angle - 4.5, 0.0)) > 0.85
    others = (np.sin(6.0 * angle), np.sign(speed), acceleration / 100.0, np.zeros(time.size))
    assert max(map(along, others)) < 0.75


def test_missing_torque_is_put_on_its_side_of_the_clearance() -> None:
    """A drag that grows with speed: on the rotor, on the load; nothing said without a rod scale."""
    assert acts_on_load(replayed({"x_quadratic_drag": {"drag_nm_s2_per_rad2": 4e-4}})) is False
    assert acts_on_load(replayed({"load_coulomb_friction": {"coulomb_nm": 0.1}})) is True
    assert acts_on_load(without("rod_position_m")) is None


def test_a_healthy_drive_reaches_no_limit() -> None:
    """Peaks and rests of a healthy drive are no limits; neither is the level of a constant load."""
    assert not limit_reached(replayed({}))
    assert not limit_reached(replayed({"stiffness_error": {"stiffness_nm_per_rad": 2000.0}}))


def evidence(angle: np.ndarray, error: np.ndarray, **more: np.ndarray) -> SimpleNamespace:
    """Evidence of a drive whose rod error is given over the rotor's angle."""
    return SimpleNamespace(
        drive=exact("bench"),
        time_s=np.arange(len(angle)) * 1e-3,
        rotor_angle_rad=angle,
        rod_error_rad=error,
        **more,
    )


def test_an_error_over_the_rotors_turn_is_the_encoders() -> None:
    """Harmonics of the rotor's angle are an encoder's, harmonics of the screw's are not."""
    angle = 30.0 * np.sin(np.linspace(0.0, 20.0, 4000))
    rng = np.random.default_rng(3)
    noise = 1e-4 * rng.standard_normal(len(angle))
    screw = angle / exact("bench").transmission.gear_ratio
    assert goes_with_encoder(evidence(angle, 1e-3 * np.sin(2.0 * angle + 0.4) + noise), 1e-4)
    assert not goes_with_encoder(evidence(angle, 1e-3 * np.sin(screw) + noise), 1e-4)
    assert not goes_with_encoder(evidence(angle, 1e-3 * np.sign(np.gradient(angle)) + noise), 1e-4)


def test_a_wrong_torque_constant_goes_with_the_current() -> None:
    """All of a torque in proportion to the current, none of one in quadrature with it."""
    angle = np.linspace(0.0, 40.0, 4000)
    current = np.sin(angle)
    same = evidence(angle, angle, current_a=current, torque_nm=0.1 * current)
    other = evidence(angle, angle, current_a=current, torque_nm=0.1 * np.cos(angle))
    assert goes_with_current(same) == pytest.approx(1.0, abs=1e-3)
    assert goes_with_current(other) == pytest.approx(0.0, abs=1e-2)


def test_a_gap_without_currents_is_laid_to_the_nearest_effect_alone() -> None:
    """Where no balance can be drawn up and nothing competes, no block is said."""
    assert said(without("current_q_a", "voltage_q_v")) is None


def test_a_limit_is_looked_for_however_small_the_floor() -> None:
    """A clipped sine without noise reaches its limit, a smaller whole one does not."""
    sine = 2.0 * np.sin(np.linspace(0.0, 60.0, 6000))
    for current, reached in ((np.clip(sine, -1.0, 1.0), True), (0.5 * sine, False)):
        replay = SimpleNamespace(
            signals=[SimpleNamespace(name="current_q")],
            recorded=current[None, :],
            floor=np.array([1e-12]),
            usable=np.ones(len(sine), dtype=bool),
            simulate=lambda effects: sine[None, :],
        )
        assert limit_reached(replay) is reached
