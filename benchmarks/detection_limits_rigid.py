"""How often a rigid drive's fault of the stated smallest size is seen.

    python benchmarks/detection_limits_rigid.py --cases 100 --seed 1

Sound machines of the rigid study are recorded and diagnosed. What a fault of the stated size asks
for along the recorded motion (friction, load, spring: by its law) is then added to the recorded
effort, with noise of another draw, and the recording is diagnosed again. Seen: the verdict is
neither `no_gap` nor `within_sheet`.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ecyl_ros.drive.rigid.machine import Machine
from ecyl_ros.gap.diagnose import diagnose
from ecyl_ros.gap.limits.limit import Limit
from ecyl_ros.gap.study.drives import Choice, RigidDrives
from ecyl_ros.recording.signals import Recording

Law = Callable[[np.ndarray, np.ndarray], np.ndarray]

LAWS: dict[str, Law] = {
    "load_coulomb_friction": lambda position, speed: np.sign(speed),
    "rotor_coulomb_friction": lambda position, speed: np.sign(speed),
    "load_viscous_friction": lambda position, speed: speed,
    "rotor_viscous_friction": lambda position, speed: speed,
    "constant_load": lambda position, speed: np.ones_like(speed),
    "spring_load": lambda position, speed: position,
}
FIELDS = {"N": "rod_force_n", "N m": "rotor_torque_nm", "A": "current_q_a", "V": "voltage_q_v"}
SOUND = ("no_gap", "within_sheet")
WANTED = (0.90, 0.99)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--cases", type=int, default=100, help="faults")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--times", type=float, nargs="+", default=[0.5, 1.0], help="of the size")
    options = parser.parse_args()
    drives = RigidDrives(None)
    seen: dict[float, list[bool]] = {one: [] for one in options.times}
    turn = 0
    for case in drives.plan(10 * options.cases, options.seed, Choice(kinds=("none",))):
        if len(seen[options.times[0]]) >= options.cases:
            break
        recording, machine, _ = drives.given(drives.complete(case))
        sound = diagnose(recording, machine)
        if sound.verdict not in SOUND:
            continue
        field = next((one for one in FIELDS.values() if recording.has(one)), "")
        stated = [
            one
            for one in sound.limits
            if one.effect in LAWS
            and one.smallest_seen is not None
            and FIELDS.get(_effort_unit(one)) == field
        ]
        if not stated:
            continue
        limit = stated[turn % len(stated)]
        turn += 1
        answers = {}
        for times in options.times:
            faulty = _with(recording, machine, limit, times, field)
            answers[times] = diagnose(faulty, machine).verdict not in SOUND
            seen[times].append(answers[times])
        print(f"{case.index:4d} {limit.effect:26s} {limit.smallest_seen:.3g} {answers}", flush=True)
    for times, found in seen.items():
        share = 100.0 * float(np.mean(found))
        print(f"{times:g} times the stated size: {share:.1f} % of {len(found)} seen")
    rate = float(np.mean(seen[1.0]))
    return 0 if WANTED[0] <= rate <= WANTED[1] else 1


def _effort_unit(limit: Limit) -> str:
    """Of the effort that a size is counted in: N s/m are N per speed."""
    unit = limit.unit.split("/")[0].removesuffix(" s")
    return unit


def _with(
    recording: Recording, machine: Machine, limit: Limit, times: float, field: str
) -> Recording:
    """The recording with what the fault asks for on top of its effort."""
    where = "rod_position_m" if machine.linear else "rotor_position_rad"
    position = recording.signal(where)
    speed = np.gradient(position, recording.time_s)
    width = max(3, round(0.01 * recording.rate_hz)) | 1
    speed = np.convolve(speed, np.ones(width) / width, mode="same")
    assert limit.smallest_seen is not None
    asked = times * limit.smallest_seen * LAWS[limit.effect](position, speed)
    effort = recording.signal(field)
    noise = 0.1 * np.nanstd(np.diff(effort)) * np.random.default_rng(7).normal(size=effort.size)
    return replace(recording, **{field: effort + asked + noise})


if __name__ == "__main__":
    sys.exit(main())
