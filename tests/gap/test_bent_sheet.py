"""Effects that a sheet, bent to stand in for them, would keep away."""

from __future__ import annotations

import dataclasses
import math

from ecyl_ros.drive.drive_file import load_drive
from ecyl_ros.drive.engine import simulate
from ecyl_ros.drive.telemetry import simulation_recording
from ecyl_ros.gap.compete.candidates import Candidates
from ecyl_ros.gap.fit.fit import Fitter
from ecyl_ros.gap.replay.replay import Replay
from ecyl_ros.gap.study.cylinder.sheet import stated_tolerances
from ecyl_ros.investigate.survey import survey

NAME, OTHER, LENGTH_S = "rotor_inertia_error", "load_inertia_error", 4.0


def test_an_effect_is_found_from_the_sheet_as_it_is_as_well() -> None:
    """Half as much rotor inertia again, its flanks rattling: the sheet alone leaves its tolerances
    for it, and from there no way leads to the true inertia; another one comes nearer."""
    nominal = dataclasses.replace(
        load_drive("servo_1khz"), telemetry_rate=1000.0, tolerances=stated_tolerances(0.01)
    )
    motor, load = nominal.motor, nominal.load
    true = 1.5 * motor.rotor_inertia
    machine = dataclasses.replace(
        nominal,
        motor=dataclasses.replace(
            motor,
            resistance=1.014 * motor.resistance,
            torque_constant=1.018 * motor.torque_constant,
        ),
        load=dataclasses.replace(load, inertia=1.003 * load.inertia),
        effects={NAME: {"inertia_kg_m2": true}},
    )
    motion, _ = survey(nominal, LENGTH_S)
    rate = nominal.sample_rate
    run = simulate(machine, lambda index: motion.sample(index / rate), LENGTH_S)
    replay = Replay(simulation_recording(run, machine), nominal, "machine")
    fitter = Fitter(replay, replay.held_out())
    candidates = Candidates(fitter, [NAME, OTHER])
    assert abs(candidates.null.pulls).max() > 1.0  # bent, and far from the floor all the same
    assert math.sqrt(candidates.null.fitted) > 2.0 * fitter.perfect
    found = candidates.singles(lambda share: None)[0]
    assert found.names == (NAME,)
    assert math.sqrt(found.judged) < 1.2 * fitter.perfect
    assert abs(found.values[NAME]["inertia_kg_m2"] / true - 1.0) < 0.03
