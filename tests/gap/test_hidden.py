"""What a noise floor hides is no evidence: healthy machines whose loop is nearly unstable."""

from __future__ import annotations

import dataclasses
import math
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
from sheets import exact

from ecyl_ros.drive.engine import simulate
from ecyl_ros.drive.telemetry import simulation_recording
from ecyl_ros.drive.tolerances import with_constants
from ecyl_ros.gap.compete.earn import excused
from ecyl_ros.gap.diagnose import diagnose
from ecyl_ros.gap.fit.fit import Fit, Fitter
from ecyl_ros.gap.replay.hidden import Hidden
from ecyl_ros.gap.replay.replay import Replay
from ecyl_ros.recording.signals import Recording

DRIVE = exact("bench")
SECONDS = 3.2
RINGING = {"actuation_delay": {"delay_s": 1.5e-4}}
FRICTION = {"load_viscous_friction": {"viscous_nm_s_per_rad": 0.006}}


def _recording(effects, **constants: float) -> Recording:
    """The emulated drive with effects and constants, its sensors' noise in the recording alone."""

    def wanted(index: int) -> tuple[float, float]:
        place = speed = 0.0
        for size, frequency in ((2e-3, 0.7), (3e-4, 3.1), (5e-5, 11.0)):
            rate = 2.0 * math.pi * frequency
            angle = rate * index / DRIVE.sample_rate
            place += size * (1.0 - math.cos(angle))
            speed += size * rate * math.sin(angle)
        return place, speed

    machine = dataclasses.replace(with_constants(DRIVE, constants), effects=effects)
    quiet = dataclasses.replace(machine.sensors, noise_seed=3)
    noises = {
        "rotor_position_noise": "rotor_position_rad",
        "rotor_velocity_noise": "rotor_velocity_rad_per_s",
        "current_noise": "current_q_a",
        "rod_position_noise": "rod_position_m",
    }
    silent = dataclasses.replace(quiet, **dict.fromkeys(noises, 0.0))
    drive = dataclasses.replace(machine, sensors=silent)
    run = simulation_recording(simulate(drive, wanted, SECONDS), drive)
    rng = np.random.default_rng(5)
    return dataclasses.replace(
        run,
        **{
            column: getattr(run, column)
            + getattr(DRIVE.sensors, noise) * rng.standard_normal(len(run))
            for noise, column in noises.items()
        },
    )


@pytest.fixture(scope="module")
def hidden() -> Hidden:
    return Hidden(Replay(_recording({}), DRIVE, "sound"))


def _rms(left: np.ndarray) -> float:
    return float(np.sqrt(np.mean(left**2, axis=2)).max())


def test_what_is_hidden_leaves_the_nominal_model_without_a_gap(hidden: Hidden) -> None:
    """Constants as far off as they can be unseen add at most 15 % to a floor, and not nothing."""
    left = _rms(hidden.left_with({}, {}))
    assert left > 0.2 and math.hypot(1.0, left) <= 1.15 + 1e-6


def test_a_loop_at_the_edge_of_stability_makes_floors_of_what_is_hidden(hidden: Hidden) -> None:
    """With a delay that rings it is more than three floors, with viscous friction less than one."""
    assert _rms(hidden.left_with(RINGING, {})) > 3.0
    assert _rms(hidden.left_with(FRICTION, {})) < 1.0


def test_a_cause_that_would_not_show_alone_is_small(hidden: Hidden) -> None:
    """A resistance off by a tenth shows by itself, by a thousandth it does not."""

    def off(share: float) -> dict[str, dict[str, float]]:
        return {"resistance_error": {"resistance_ohm": (1.0 + share) * DRIVE.motor.resistance}}

    assert not hidden.small(off(0.1))
    assert hidden.small(off(1e-3))


def test_a_delay_that_rings_is_named_alone_on_a_sound_machine() -> None:
    """A resistance off by 0.2 % and a load by 0.01 %, which nobody sees: the delay is the cause."""
    machine = {
        "motor.resistance": 1.002 * DRIVE.motor.resistance,
        "load.inertia": 1.0001 * DRIVE.load.inertia,
    }
    assert diagnose(_recording({}, **machine), DRIVE).verdict == "no_gap"
    result = diagnose(_recording(RINGING, **machine), DRIVE)
    assert [one.effect for one in result.causes] == ["actuation_delay"]
    assert result.causes[0].parameters[0].value == pytest.approx(1.5e-4, rel=0.02)
    assert result.causes[0].confidence > 0.9


def test_what_is_left_is_excused_by_a_loop_that_amplifies_not_by_its_noise_alone() -> None:
    """Of what stands above a sound machine with the effects most has to be gone, and something
    has to stand above it."""

    def is_excused(before: float, left: float, sound: float) -> bool:
        fitter = SimpleNamespace(nominal=SimpleNamespace(judged=before**2))
        return excused(cast(Fitter, fitter), cast(Fit, SimpleNamespace(judged=left**2)), sound)

    assert is_excused(before=3.1, left=2.4, sound=2.65)
    assert not is_excused(before=3.1, left=2.95, sound=2.65)  # near, and hardly anything is gone
    assert not is_excused(before=6.0, left=3.2, sound=2.65)  # more is left than noise
    assert not is_excused(before=2.6, left=2.4, sound=2.65)  # its noise is as large as the gap


def test_a_late_signal_is_found_beside_a_softer_shaft_that_hides_it() -> None:
    """A wrong feedforward stands for the delay, until that begins upon the softer shaft."""
    both = {
        "measurement_delay": {"delay_s": 2.6e-4},
        "stiffness_error": {"stiffness_nm_per_rad": 0.22 * DRIVE.transmission.stiffness[0]},
    }
    result = diagnose(_recording(both), DRIVE)
    assert {one.effect for one in result.causes} == set(both)
