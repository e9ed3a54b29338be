"""The state in which the live twin begins in the middle of a motion."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from ecyl_ros.drive.cascade import cascade_step, initial_cascade_state
from ecyl_ros.drive.drive_file import load_drive
from ecyl_ros.drive.packed import pack
from ecyl_ros.drive.parameters import Gains, PositionGains
from ecyl_ros.drive.plant import MEASURED
from ecyl_ros.gap.live.start import state_from
from ecyl_ros.gap.replay.sensor_noise import declared_noise

CONTROLLERS = {
    "cascade": {},
    "feedforward and series": {"velocity_feedforward": 0.7, "form": "series"},
    "derivative": {"position": PositionGains(kp=40.0, kd=0.2)},
    "no speed loop": {
        "structure": "position_to_current",
        "position": PositionGains(kp=32.0, ki=100.0, kd=0.8),
        "speed": Gains(kp=0.0),
    },
}


@pytest.mark.parametrize("kind", CONTROLLERS)
def test_the_first_command_is_the_one_recorded(kind: str) -> None:
    """With the integrals found from one sample in motion the controller, given that sample, asks
    for the current that flows and hence commands the voltage that was recorded."""
    plain = load_drive("bench")
    control = dataclasses.replace(plain.controller, **CONTROLLERS[kind])
    drive = dataclasses.replace(plain, controller=control)
    ratio = drive.transmission.rod_per_rotor
    first = {
        "rotor_position_rad": 3.0,
        "rotor_velocity_rad_per_s": 9.0,
        "rod_position_m": 3.0 * ratio,
        "current_q_a": 0.8,
        "current_d_a": 0.0,
        "rotor_torque_nm": math.nan,
        "voltage_q_v": 2.3,
        "voltage_d_v": 0.0,
    }
    wanted_m, wanted_m_per_s = 3.2 * ratio, 10.0 * ratio
    state = state_from(first, wanted_m, wanted_m_per_s, drive, declared_noise(drive))
    cascade = initial_cascade_state(pack(drive))
    cascade[0][:] = state.integrals
    measured, voltage = np.zeros(len(MEASURED)), np.zeros(2)
    for name in ("rotor_position_rad", "rotor_velocity_rad_per_s", "current_q_a"):
        measured[MEASURED.index(name)] = first[name]
    cascade_step(cascade, wanted_m, wanted_m_per_s, measured, pack(drive), voltage)
    assert voltage[1] == pytest.approx(2.3, rel=1e-9)
