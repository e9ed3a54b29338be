"""What a run looks like on the contract's topics: one set of rules for the nodes and the engine.

The plant node fills its messages with `joint_values`; `simulation_recording` makes a `Recording`
of an engine run by the same arithmetic, so both write the same bytes.
"""

from __future__ import annotations

import math

import numpy as np

from ..recording.signals import Recording
from . import engine
from .parameters import DriveParameters

NANOSECONDS = 1_000_000_000


def tick_stamp_ns(tick: int, rate: float, epoch_ns: int = 0) -> int:
    """Stamp of a control tick, ns: the epoch plus the tick's instant, rounded."""
    return epoch_ns + round(tick * NANOSECONDS / rate)


def joint_values(
    measured: list[float], load_angle: float, load_speed: float, drive: DriveParameters
) -> tuple[list[float], list[float], list[float]]:
    """Positions, velocities and efforts of the joints rotor, rod, load (rad, m, rad; ...).

    measured: in the order of `plant.MEASURED`. The rotor's effort is torque constant x i_q, the
    rod's the transmitted torque as a force; the load's is not given.
    """
    return (
        [measured[0], measured[2], load_angle],
        [measured[1], measured[3], load_speed],
        [
            drive.motor.torque_constant * measured[5],
            measured[6] / drive.transmission.rod_per_rotor,
            math.nan,
        ],
    )


def simulation_recording(
    simulation: engine.Simulation, drive: DriveParameters, epoch_ns: int = 0
) -> Recording:
    """The recording that the node graph would have made of this run."""
    samples, every, rate = simulation.samples, drive.telemetry_every, drive.controller.rate
    stamps = [tick_stamp_ns(index * every, rate, epoch_ns) for index in range(len(samples))]
    torque = simulation.signal("transmitted_torque_nm")
    return Recording(
        stamp_ns=np.array(stamps, dtype=np.int64),
        reference_position_m=samples[:, engine.REFERENCE],
        reference_velocity_m_per_s=samples[:, engine.REFERENCE_VELOCITY],
        rotor_position_rad=simulation.signal("rotor_position_rad"),
        rotor_velocity_rad_per_s=simulation.signal("rotor_velocity_rad_per_s"),
        rotor_torque_nm=drive.motor.torque_constant * simulation.signal("current_q_a"),
        rod_position_m=simulation.signal("rod_position_m"),
        rod_velocity_m_per_s=simulation.signal("rod_velocity_m_per_s"),
        rod_force_n=torque / drive.transmission.rod_per_rotor,
        load_position_rad=samples[:, engine.LOAD],
        load_velocity_rad_per_s=samples[:, engine.LOAD + 1],
        current_d_a=simulation.signal("current_d_a"),
        current_q_a=simulation.signal("current_q_a"),
        voltage_d_v=samples[:, engine.VOLTAGE],
        voltage_q_v=samples[:, engine.VOLTAGE + 1],
    )
