"""Planned separations against those measured once the motion is played, and against other motions.

    python benchmarks/planned_motion.py --seed 1

For each pair of effects that are known to look alike, a motion is planned, and a machine of the
sealed study (equations of its own, constants off the sheet) with either effect plays it, and moves
of the same limits and time. Both effects are then fitted to each recording beside the sheet;
measured is what the wrong one leaves above the right one, as the plan counts it.
"""

from __future__ import annotations

import argparse
import dataclasses
import math
import sys
import time

import numpy as np
from detection_limits import fitter_of, true_pulls

from ecyl_ros.drive.drive_file import load_drive, resolve_drive
from ecyl_ros.drive.parameters import DriveParameters
from ecyl_ros.drive.reference.base import Reference
from ecyl_ros.gap.replay.replay import SIGNALS
from ecyl_ros.gap.study.cylinder.cases import stated
from ecyl_ros.gap.study.cylinder.machine import record_machine
from ecyl_ros.gap.study.cylinder.stage import Setup, Stage
from ecyl_ros.plan.fitted import separation
from ecyl_ros.plan.hypotheses import Hypothesis
from ecyl_ros.plan.make import make_plan

PAIRS = (
    ("rotor_coulomb_friction", "load_coulomb_friction"),
    ("rotor_viscous_friction", "load_viscous_friction"),
    ("constant_load", "current_sensor_offset"),
    ("measurement_delay", "actuation_delay"),
    ("backlash_error", "stiffness_error"),
    ("inverter_dead_time", "resistance_error"),
    ("rotor_inertia_error", "load_inertia_error"),
    ("torque_constant_error", "back_emf_error"),
)
FACTOR, WANTED = 1.5, 0.9
PLAYED = ("planned", "moves")
_STEPS_OF_A_DELAY = 20


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--drive", default="bench")
    parser.add_argument("--sheet", type=float, default=0.01)
    parser.add_argument("--duration", type=float, default=6.0)
    parser.add_argument("--pairs", type=int, default=len(PAIRS), help="the first so many")
    options = parser.parse_args()
    drive = load_drive(resolve_drive(options.drive))
    nominal = stated(drive, options.sheet)
    signals = tuple(one.name for one in SIGNALS)
    ratios: list[float] = []
    better = 0
    for row, names in enumerate(PAIRS[: options.pairs]):
        begin = time.perf_counter()
        plan = make_plan(nominal, options.duration, [names], [], {}, signals, [], budget_s=30.0)
        found = {one.motion: one for one in plan.predictions}
        usual = {name: one.apart[0] for name, one in found.items() if name != "planned"}
        better += found["planned"].apart[0] >= max(usual.values())
        print(
            f"{names[0]} | {names[1]}: planned {found['planned'].apart[0]:.2f}, "
            + ", ".join(f"{name} {value:.2f}" for name, value in usual.items())
            + f" ({time.perf_counter() - begin:.0f} s)",
            flush=True,
        )
        pair = plan.pairs[0]
        stage = Stage.of(1000 * options.seed + row, Setup(drive), options.sheet)
        for motion in PLAYED:
            measured = min(
                _measured(acting, other, found[motion].reference, drive, nominal, stage, options)
                for acting, other in ((pair.first, pair.second), (pair.second, pair.first))
            )
            predicted = found[motion].apart[0]
            # Where both say that a diagnosis cannot tell the two, they agree.
            neither = max(measured, predicted) < plan.needed
            ratios.append(1.0 if neither else measured / max(predicted, 1e-12))
            print(
                f"    {motion:8s} predicted {predicted:.3f}, measured {measured:.3f}, ratio "
                f"{ratios[-1]:.2f}",
                flush=True,
            )
    within = sum(1.0 / FACTOR <= one <= FACTOR for one in ratios) / len(ratios)
    print(f"{100.0 * within:.0f} % of {len(ratios)} within a factor of {FACTOR:g}")
    print(f"planned motion best of all in {better} of {options.pairs} pairs")
    return 0 if within >= WANTED else 1


def _measured(
    acting: Hypothesis,
    other: Hypothesis,
    reference: Reference,
    drive: DriveParameters,
    nominal: DriveParameters,
    stage: Stage,
    options: argparse.Namespace,
) -> float:
    """What the other effect leaves above the one that acts, in floors."""
    ticks = round(options.duration * drive.controller.rate) + 1
    shown = np.array([reference.sample(tick / drive.controller.rate) for tick in range(ticks)])
    machine = stage.with_effects({acting.effect: dict(acting.values)}, options.seed)
    # The machine's delays are whole steps of its integrator: small ones need small steps.
    least_s = acting.values.get("delay_s", math.inf) / _STEPS_OF_A_DELAY
    steps = max(stage.nuisances.steps_per_tick, math.ceil(1.0 / (drive.controller.rate * least_s)))
    nuisances = dataclasses.replace(stage.nuisances, steps_per_tick=steps)
    recording = record_machine(machine, nuisances, drive, (shown[:, 0].copy(), shown[:, 1].copy()))
    fitter = fitter_of(recording, nominal)
    return separation(fitter, acting, other, true_pulls(fitter, stage))


if __name__ == "__main__":
    sys.exit(main())
