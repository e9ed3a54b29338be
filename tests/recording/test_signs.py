"""Signs that contradict each other, told from loads that drive the motor and springs that hold."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ecyl_ros.cli.main import main
from ecyl_ros.recording.map_file import parse_map
from ecyl_ros.recording.mapped import read_mapped
from ecyl_ros.recording.screening import with_sign_notes
from ecyl_ros.recording.signals import Recording
from ecyl_ros.recording.signs import wrong_signs

TIME = np.arange(8000) * 1e-3


def driven(
    *, spring: float = 0.0, gravity: float = 0.0, friction: float = 0.3, pure: bool = False
) -> dict[str, np.ndarray]:
    """A motor of 0.01 kg m2 on a sum of sines: the torque that its motion needs, with noise."""
    random = np.random.default_rng(5)
    angle = 6.0 * np.sin(2.0 * np.pi * 0.5 * TIME)
    if not pure:
        angle += 1.5 * np.sin(2.0 * np.pi * 1.7 * TIME + 1.0) + 0.4 * np.sin(
            2.0 * np.pi * 4.1 * TIME
        )
    speed = np.gradient(angle, TIME)
    torque = 0.01 * np.gradient(speed, TIME) + friction * np.tanh(speed / 0.1) + 0.02 * speed
    torque += spring * angle + gravity
    return {
        "reference_position_rad": angle,
        "rotor_position_rad": angle + random.normal(scale=1e-4, size=TIME.size),
        "rotor_velocity_rad_per_s": speed + random.normal(scale=0.05, size=TIME.size),
        "rotor_torque_nm": torque + random.normal(scale=0.02, size=TIME.size),
    }


def wrong(signals: dict[str, np.ndarray]) -> list[str]:
    stamps = np.round(TIME * 1e9).astype(np.int64)
    return [one.signal for one in wrong_signs(Recording(stamp_ns=stamps, **signals))]


@pytest.mark.parametrize(
    "load",
    [
        {},
        {"friction": 0.0},
        {"gravity": 2.0},
        {"gravity": -2.0},
        {"spring": 1.0},
        {"spring": 1.0, "pure": True, "friction": 0.02},
        {"friction": 2.0},
    ],
)
def test_sound_loads_have_the_right_sign(load: dict) -> None:
    """Gravity either way, a spring that outdoes the inertia and much friction are no wrong sign."""
    assert wrong(driven(**load)) == []


@pytest.mark.parametrize("load", [{}, {"gravity": 2.0}, {"friction": 2.0}, {"friction": 0.05}])
@pytest.mark.parametrize(
    "signal", ["rotor_torque_nm", "rotor_velocity_rad_per_s", "rotor_position_rad"]
)
def test_one_signal_turned_is_named(load: dict, signal: str) -> None:
    """Whichever one signal counts backward is named, and no other."""
    signals = driven(**load)
    signals[signal] = -signals[signal]
    assert wrong(signals) == [signal]


def test_a_load_that_drives_the_motor_is_no_wrong_sign() -> None:
    """Of a load that is let down power comes back all the way, but inertia still asks."""
    signals = driven(friction=0.0)
    signals["rotor_torque_nm"] = signals["rotor_torque_nm"] - 0.5 * np.tanh(
        signals["rotor_velocity_rad_per_s"]
    )
    assert wrong(signals) == []


def test_an_effort_without_its_sign_is_named(tmp_path: Path) -> None:
    """A torque given as a size alone, as some servos do, is told by touching 0 from above."""
    signals = driven(friction=1.0)
    signals["rotor_torque_nm"] = np.abs(np.round(signals["rotor_torque_nm"], 2))
    stamps = np.round(TIME * 1e9).astype(np.int64)
    (found,) = wrong_signs(Recording(stamp_ns=stamps, **signals))
    assert "rotor_torque_nm has lost its sign" in found.text
    read = with_sign_notes(Recording(stamp_ns=stamps, **signals), "r", {found.signal: "effort"})
    assert read.notes[0].endswith("expected it logged with its sign, which no map can restore")


def test_the_note_comes_first_and_says_what_to_write(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Read by a map the first note names signal and key; inspect prints it above the proposal."""
    signals = driven()
    rows = "\n".join(
        f"{t:.3f},{r:.6f},{p:.6f},{v:.5f},{-e:.5f}"
        for t, (r, p, v, e) in zip(TIME, zip(*signals.values(), strict=True), strict=True)
    )
    path = tmp_path / "a.csv"
    path.write_text(f"t,target_rad,motor_rad,motor_speed_rad_per_s,motor_torque_nm\n{rows}\n")
    tree = {
        "signals": {
            "rotor_velocity": "motor_speed_rad_per_s",
            "rotor_torque": {"field": "motor_torque_nm", "unit": "N m"},
        }
    }
    note = read_mapped(path, parse_map(tree, "m")).notes[0]
    assert "rotor_torque_nm has the wrong sign: it goes against the acceleration" in note
    assert "expected sign: -1 for signals.rotor_torque" in note
    assert main(["inspect", str(path)]) == 0
    assert "# rotor_torque_nm has the wrong sign" in capsys.readouterr().out


def test_a_voltage_that_needs_none_at_rest_has_lost_its_sign() -> None:
    """A winch by unsigned PWM: 1.4 V up, 0.6 V down, none at rest; what a weight asks for at rest,
    too, is no lost sign."""
    way = np.repeat([1.0, 0.0, -1.0, 0.0] * 4, 500)
    time = np.arange(way.size) * 1e-3
    smooth = np.convolve(way, np.ones(41) / 41.0, "same")
    signals = {
        "rotor_velocity_rad_per_s": 200.0 * smooth,
        "rotor_position_rad": 0.2 * np.cumsum(smooth),
        "voltage_q_v": np.where(way > 0.0, 1.4, 0.0) + np.where(way < 0.0, 0.6, 0.0),
    }
    stamps = np.round(time * 1e9).astype(np.int64)
    (found,) = wrong_signs(Recording(stamp_ns=stamps, **signals))
    assert found.signal == "voltage_q_v" and "lost its sign" in found.text
    held = {**signals, "voltage_q_v": np.maximum(signals["voltage_q_v"], np.where(way, 0.0, 1.0))}
    held["voltage_q_v"][:20] = 0.0
    assert wrong_signs(Recording(stamp_ns=stamps, **held)) == []
