"""`ecyl investigate` on emulated drives with sealed faults: how many are decided, and rightly.

    python benchmarks/investigate.py --cases 20 --seed 1
    python benchmarks/investigate.py --cases 20 --seed 1 --drive servo_1khz --realtime \
        --rate 100 --bandwidth 0.5

Each case draws a machine: its constants off their sheet, and one fault of a size that the blind
study draws. The node graph of that machine is launched, and the command is given the data sheet
alone. Printed are what it decided and after how many motions, and every sample of every recording
beyond the drive's limits.
"""

from __future__ import annotations

import argparse
import dataclasses
import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import yaml

from ecyl_ros.drive.drive_file import drive_from_flat, drive_to_flat, load_drive, with_rate
from ecyl_ros.drive.engine import simulate
from ecyl_ros.drive.parameters import DriveParameters
from ecyl_ros.drive.stability import is_stable
from ecyl_ros.drive.telemetry import simulation_recording
from ecyl_ros.effects.catalogue import CATALOGUE
from ecyl_ros.gap.study.cylinder.imposed import Draw, Scale, Values
from ecyl_ros.gap.study.cylinder.inside import INSIDE
from ecyl_ros.gap.study.cylinder.sheet import (
    draw_errors,
    leaving_the_sheet,
    stated_tolerances,
    taken_by,
)
from ecyl_ros.gap.study.cylinder.stage import peak
from ecyl_ros.investigate.survey import survey
from ecyl_ros.recording.reader import read_recording

# The controller of a drive file calculates with the lead of that file, and no real controller knows
# what its machine truly has.
BELIEVED = {"transmission.lead"}
TARGET = 0.95  # decided and right, within the motions allowed
_SLACK = 1e-6


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--cases", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0, help="case to begin with")
    parser.add_argument("--drive", default="bench")
    parser.add_argument("--sheet", type=float, default=0.01, help="relative sd off the sheet")
    parser.add_argument("--motions", type=int, default=3)
    parser.add_argument("--duration", type=float, default=8.0)
    parser.add_argument("--realtime", action="store_true")
    parser.add_argument("--rate", type=float, help="Hz of the controller, instead of the drive's")
    parser.add_argument("--bandwidth", type=float, default=1.0, help="of the loops, times theirs")
    parser.add_argument("--keep", type=Path, help="folder to keep everything in")
    options = parser.parse_args()
    drive = load_drive(options.drive)
    drive = with_rate(_slower(drive, options.bandwidth), options.rate, options.drive)
    nominal = dataclasses.replace(
        drive,
        telemetry_rate=min(1000.0, drive.controller.rate),
        tolerances=stated_tolerances(options.sheet),
    )
    names = sorted(INSIDE)
    order = np.random.default_rng(options.seed).permutation(len(names))
    decided = right = beyond = samples = 0
    motions: list[int] = []
    cases = range(options.first, options.first + options.cases)
    for case in cases:
        name = names[order[case % len(names)]]
        begin = time.monotonic()
        with tempfile.TemporaryDirectory(prefix="ecyl_") as temporary:
            folder = Path(options.keep or temporary, f"case_{case}")
            story, said = _investigated(case, name, nominal, folder, options)
            count, outside = _samples(folder / "found", nominal)
        samples, beyond = samples + count, beyond + outside
        last = next((one for one in reversed(story["steps"]) if one["verdict"]), None)
        causes = last["causes"] if last else []
        good = story["outcome"] == "decided" and bool(causes) and causes[0] == name
        good &= set(causes) <= {name} | INSIDE[name].akin
        decided, right = decided + (story["outcome"] == "decided"), right + good
        motions.append(len(story["steps"]))
        print(
            f"{case:3d} {name:24s} {'right' if good else 'NOT':5s} {story['outcome']:8s} after "
            f"{len(story['steps'])}: {', '.join(causes) or (last or {}).get('verdict') or said} "
            f"({story['reason']}; {time.monotonic() - begin:.0f} s)",
            flush=True,
        )
    print(
        f"decided within {options.motions} motions: {decided} of {options.cases}; decided and "
        f"right: {right} of {options.cases} (target {TARGET:.0%})"
    )
    print(f"motions: {', '.join(f'{motions.count(n)} with {n}' for n in sorted(set(motions)))}")
    print(f"samples beyond stroke, speed, acceleration or current: {beyond} of {samples}")
    return 0 if right >= TARGET * options.cases and beyond == 0 else 1


def _slower(drive: DriveParameters, share: float) -> DriveParameters:
    """The drive with loops of a share of their bandwidth, each as well damped as before."""
    controller = drive.controller
    position, speed, current = (
        dataclasses.replace(one, kp=share * one.kp, ki=share**2 * one.parallel_ki(controller.form))
        for one in (controller.position, controller.speed, controller.current)
    )
    gains = dataclasses.replace(
        controller, form="parallel", position=position, speed=speed, current=current
    )
    return dataclasses.replace(drive, controller=gains)


def _investigated(
    case: int, name: str, nominal: DriveParameters, folder: Path, options: argparse.Namespace
) -> tuple[dict, str]:
    """The story that the command tells of a case, and what it said on stderr."""
    folder.mkdir(parents=True)
    seed = 1000 * options.seed + case
    hidden = _drawn(seed, name, nominal, options.sheet, options.duration)
    for drive, file in ((nominal, "sheet.yaml"), (hidden, "hidden.yaml")):
        flat = drive_to_flat(drive)
        text = yaml.safe_dump({"/**": {"ros__parameters": flat}}, sort_keys=False)
        (folder / file).write_text(text, encoding="utf-8")
    command = [sys.executable, "-m", "ecyl_ros.cli.main", "investigate"]
    command += ["--drive", str(folder / "sheet.yaml"), "--emulate", str(folder / "hidden.yaml")]
    command += ["--out", str(folder / "found"), "--motions", str(options.motions)]
    command += ["--duration", str(options.duration)]
    command += ["--realtime"] if options.realtime else []
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    story = folder / "found" / "investigation.json"
    if not story.exists():
        return {"outcome": "none", "reason": done.stderr.strip(), "steps": []}, done.stderr
    return json.loads(story.read_text(encoding="utf-8")), done.stderr.strip()


def _drawn(
    seed: int, name: str, nominal: DriveParameters, sheet: float, duration: float
) -> DriveParameters:
    """A machine off its sheet, with one fault; drawn again where its loops would be unstable."""
    rng = np.random.default_rng([seed, 26])
    scale = _scale(nominal, duration)
    for _ in range(20):
        values: Values = INSIDE[name].draw(Draw(rng, nominal, scale))
        values = leaving_the_sheet(name, values, nominal, rng)
        if any(one.name == "phase_rad" for one in CATALOGUE[name].parameters):
            values = {**values, "phase_rad": float(rng.uniform(-np.pi, np.pi))}
        flat = drive_to_flat(nominal)
        taken = taken_by([name]) | BELIEVED
        for key, error in draw_errors(rng, sheet).items():
            if key in flat and key not in taken:
                value = flat[key]
                many = isinstance(value, list)
                flat[key] = [one * (1.0 + error) for one in value] if many else value * (1 + error)
        flat |= {f"effects.{name}.{key}": float(value) for key, value in values.items()}
        hidden = drive_from_flat(flat, f"case with {name}")
        if is_stable(hidden):
            return hidden
    raise SystemExit(f"{name}: no stable machine was drawn")


def _scale(drive: DriveParameters, duration: float) -> Scale:
    """Peaks of the healthy drive on the first motion."""
    motion, _ = survey(drive, duration)
    rate = drive.sample_rate
    run = simulate(drive, lambda index: motion.sample(index / rate), duration)
    shown = simulation_recording(run, drive)
    current = peak(shown.current_q_a)
    return Scale(
        torque_nm=drive.motor.torque_constant * current,
        current_a=current,
        voltage_v=peak(shown.voltage_q_v),
        speed_rad_s=peak(shown.rotor_velocity_rad_per_s),
        stroke_m=peak(shown.rod_position_m),
    )


def _samples(folder: Path, drive: DriveParameters) -> tuple[int, int]:
    """(samples of all recordings, how many are beyond the drive's limits)."""
    limits, count, beyond = drive.limits, 0, 0
    for path in sorted(folder.glob("*.mcap")):
        shown = read_recording(path)
        time_s = (shown.stamp_ns - shown.stamp_ns[0]) * 1e-9
        wanted, speed = shown.reference_position_m, shown.reference_velocity_m_per_s
        faster = np.abs(np.diff(speed) / np.diff(time_s))
        bad = np.abs(speed) > limits.speed * (1.0 + _SLACK)
        for place in (wanted, shown.rod_position_m):
            bad |= (place < limits.stroke_min - _SLACK) | (place > limits.stroke_max + _SLACK)
        bad |= np.abs(shown.current_q_a) > drive.controller.current_limit
        bad[1:] |= faster > limits.acceleration * (1.0 + 1e-3)
        count, beyond = count + len(bad), beyond + int(np.sum(bad))
    return count, beyond


if __name__ == "__main__":
    sys.exit(main())
