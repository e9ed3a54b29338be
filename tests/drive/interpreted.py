"""Drives of all kinds, run for a few samples; as a program: by the interpreter, to a file.

Compiled code reads beyond an array without a word. Interpreted, NumPy checks every index.
"""

from __future__ import annotations

import dataclasses
import math
import sys
from collections.abc import Iterator

import numpy as np

from ecyl_ros.drive import engine
from ecyl_ros.drive.drive_file import load_drive
from ecyl_ros.drive.law import Law
from ecyl_ros.drive.packed import pack
from ecyl_ros.drive.parameters import DriveParameters, Gains, PositionGains

SAMPLES = 12
RATE_HZ = 40.0  # of the motion: it passes a soft flank, and a table's end, both ways
_PLACES = (-2e-5, 0.0, 1e-5, 2e-5)
LAWS = {
    "a law of the place, beyond its table": Law(
        "load_friction", ("position",), (_PLACES,), (0.0, 0.3, 0.1, 0.2)
    ),
    "a law that repeats": Law(
        "rotor_torque", ("rotor_angle",), ((0.0, 2.0, 4.0),), (0.1, -0.1, 0.2), (math.tau,)
    ),
    "a law of place and heat": Law(
        "load_torque", ("position", "heat"), (_PLACES, (0.0, 2.0)), (0.1,) * 8, time_constant_s=0.5
    ),
    "a law of the current that is read": Law(
        "current_error", ("current",), ((-1.0, 1.0),), (0.1, -0.1)
    ),
    "a law of nothing": Law("inverter_voltage", (), (), (0.5,)),
}


def drives() -> Iterator[tuple[str, DriveParameters]]:
    """Profiles, and the bench drive with all that is looked up in an array."""
    for profile in ("bench", "servo_1khz", "paper"):
        yield profile, load_drive(profile)
    bench = load_drive("bench")
    controllers = {
        "two ticks of delay": {"delay_ticks": 2},
        "the rod's position fed back": {"feedback": "rod"},
        "filters": {
            "setpoint_filter": 4e-3,
            "speed_source": "differences",
            "speed_filter": 5e-4,
            "current_command_filter": 2e-4,
            "acceleration_feedforward": 2e-3,
        },
        "no speed loop": {
            "structure": "position_to_current",
            "position": PositionGains(kp=32.0, ki=100.0, kd=0.8),
            "speed": Gains(kp=0.0),
        },
    }
    for name, changes in controllers.items():
        controller = dataclasses.replace(bench.controller, **changes)
        yield name, dataclasses.replace(bench, controller=controller)
    steps = dataclasses.replace(
        bench.transmission, stiffness=(20.0, 60.0, 120.0), stiffness_breaks=(5e-4, 2e-3)
    )
    yield "flanks of three segments", dataclasses.replace(bench, transmission=steps)
    tight = dataclasses.replace(steps, backlash=0.0)
    yield "flanks without clearance", dataclasses.replace(bench, transmission=tight)
    delays = {"actuation_delay": {"delay_s": 1.4e-4}, "measurement_delay": {"delay_s": 2.6e-4}}
    yield "delays of broken ticks", dataclasses.replace(bench, effects=delays)
    for name, law in LAWS.items():
        yield name, dataclasses.replace(bench, learned=law)


def samples(drive: DriveParameters) -> np.ndarray:
    """What the engine makes of a sine of 1 mm, float64[SAMPLES, COLUMNS]."""
    rate = math.tau * RATE_HZ

    def reference(index: int) -> tuple[float, float]:
        angle = rate * index / drive.sample_rate
        return 1e-3 * math.sin(angle), 1e-3 * rate * math.cos(angle)

    return engine.simulate(drive, reference, SAMPLES / drive.sample_rate).samples


if __name__ == "__main__":
    # The interpreter reads a packed record by its keys, a compiled kernel by its attributes.
    engine.pack = lambda *given, **named: pack(*given, **named).view(np.recarray)
    np.seterr(over="ignore")  # of hashes of the noise, whose words are meant to
    np.savez(sys.argv[1], **{name: samples(drive) for name, drive in drives()})
