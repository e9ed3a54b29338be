"""The block of a gap that no effect explains, from balances at the ports."""

from __future__ import annotations

import pytest

from ecyl_ros.drive.drive_file import load_drive
from ecyl_ros.effects.effect import BLOCKS
from ecyl_ros.gap.block import possible_blocks
from ecyl_ros.gap.locate import by_port
from ecyl_ros.gap.replay import Replay
from ecyl_ros.gap.study.cylinder.cases import Case, record_case

CASES = [
    ({"resistance_error": {"resistance_ohm": 1.1}}, {"motor_electrical"}),
    ({"inverter_dead_time": {"voltage_v": 1.0}}, {"motor_electrical"}),
    ({"current_sensor_offset": {"offset_a": 0.15}}, {"sensor"}),
    ({"constant_load": {"force_n": 150.0}}, {"load"}),
    ({"rotor_coulomb_friction": {"coulomb_nm": 0.2}}, {"motor_mechanical"}),
    ({"cogging_torque": {"amplitude_nm": 0.06, "periods_per_rev": 12.0}}, {"motor_mechanical"}),
    ({"x_local_jam": {"coulomb_nm": 0.5, "place_m": 0.0, "width_m": 0.001}}, {"load"}),
    ({"lead_error": {"lead_m": 0.0198}}, {"transmission"}),
    (
        {"transmission_error": {"amplitude_rad": 0.02, "periods_per_screw_rev": 1.0}},
        {"transmission"},
    ),
    ({"encoder_eccentricity": {"amplitude_rad": 0.004}}, {"sensor"}),
    ({"measurement_delay": {"delay_s": 1.5e-4}}, {"timing"}),
    ({"stiffness_error": {"stiffness_nm_per_rad": 2000.0}}, {"transmission"}),
]


@pytest.mark.parametrize(("effects", "block"), CASES, ids=[next(iter(e)) for e, _ in CASES])
def test_port_checks_leave_the_true_block(effects, block) -> None:
    """On another make of machine the balances at the ports rule out blocks, never the true one."""
    drive = load_drive("bench")
    replay = Replay(record_case(Case(0, 9, "single", effects), drive), drive, "recording")
    possible = set(possible_blocks(by_port(replay)))
    assert block <= possible
    assert len(possible) <= 3 < len(BLOCKS)


def test_without_electrical_signals_nothing_is_ruled_out() -> None:
    """No port checks, no block ruled out."""
    assert set(possible_blocks(())) == set(BLOCKS)
