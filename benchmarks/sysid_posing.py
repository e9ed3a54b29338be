"""Rigid drives as both are asked about them: the machines of `sysid_peer`, and their windows.

Machines are drawn by the study of rigid drives, or read from folders of recordings. `pose` divides
a recording into windows to fit and to judge; `problem_of` says it in the toolbox's terms.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from ecyl_ros.drive.rigid.driven import pieces
from ecyl_ros.drive.rigid.machine import Machine
from ecyl_ros.drive.rigid.machine_file import load_machine
from ecyl_ros.errors import InputError
from ecyl_ros.gap.replay.screen import LONGEST_S
from ecyl_ros.gap.rigid.balance import HELD_OUT_EVERY, Balance
from ecyl_ros.gap.rigid.motion import Motion, motion_of
from ecyl_ros.gap.rigid.terms import Catalogue
from ecyl_ros.gap.study.drives import Choice, RigidDrives
from ecyl_ros.recording.load import load_stretch
from ecyl_ros.recording.map_file import load_map
from ecyl_ros.recording.signals import Recording

# Causes that are a parameter of the joint (but for the side that a name begins with), and some that
# are none. A back-EMF is damping where voltage is recorded, a wrong gain a factor of the others.
# MuJoCo has other means to pose an arm's weight or a delay, so that these are on neither side.
POSED = (
    "viscous_friction",
    "coulomb_friction",
    "inertia_error",
    "constant_load",
    "spring_load",
    "back_emf_error",
    "torque_constant_error",
)
BEYOND = (
    "cogging_torque",
    "torque_ripple",
    "stribeck_friction",
    "direction_dependent_friction",
    "friction_drift",
    "local_jam",
    "load_dependent_friction",
    "periodic_disturbance",
)
_MOVES = 0.5  # share of a window that has to be in motion
_REACH = 10.0  # times the inertia that the fit begins with, either way: its bounds
_ROOM = 3.0  # times what would take all the effort: bounds of the rest
PLANNED = 200  # cases of either side, whatever is asked for: the first are always the same


@dataclass(frozen=True, eq=False)
class Subject:
    """One machine to be judged on.

    truth: what is known to be wrong with it, None where nobody knows. posed: whether all of that is
    a parameter of the joint. seen: whether the recording can show it, by the study's own label;
    None where nobody knows.
    """

    name: str
    recording: Recording
    machine: Machine
    mode: float | None
    truth: str | None
    posed: bool
    seen: bool | None = None


@dataclass(frozen=True, eq=False)
class Posed:
    """A subject as both are given it.

    scale: of position and speed, by which errors are divided. fitted, held_out: windows,
    int64[k, 2].
    """

    motion: Motion
    balance: Balance
    catalogue: Catalogue
    scale: np.ndarray
    fitted: np.ndarray
    held_out: np.ndarray

    def motion_error(self, position: np.ndarray, speed: np.ndarray) -> float:
        """Of a simulation of the held-out windows, float64[n] each; inf where it ran away."""
        rows = np.concatenate([np.arange(a + 1, b) for a, b in self.held_out])
        motion = self.motion
        off = np.stack([position - motion.raw_position, speed - motion.velocity])[:, rows]
        value = float(np.sqrt(np.mean((off / self.scale[:, None]) ** 2)))
        return value if math.isfinite(value) else math.inf

    def effort_error(self, effort: np.ndarray) -> float:
        """Of the effort that the motion asks for by a model, float64[n]."""
        rows = self.balance.judged
        off = (self.motion.filtered(effort) - self.balance.effort)[rows]
        size = float(np.sqrt(np.mean(self.balance.effort[rows] ** 2)))
        return float(np.sqrt(np.mean(off**2))) / size


def is_posed(effect: str) -> bool:
    """Whether a cause is one of the joint's parameters."""
    return effect.removeprefix("load_").removeprefix("rotor_") in POSED


def drawn(count: int, seed: int) -> Iterator[Subject]:
    """Machines of the study with recorded effort, by turns with a cause that is posed and not.

    Both sides are drawn of one seed: some machines are the same drive with another fault.
    """
    drives = RigidDrives()
    within = tuple(name for name in drives.effects if is_posed(name))
    queues = [
        iter(drives.plan(PLANNED, seed, Choice(("single",), effects)))
        for effects in (within, BEYOND)
    ]
    for index in range(count):
        while True:
            case = drives.complete(next(queues[index % 2]))
            if case.facts["actuation"] != "loop":
                break
        given = drives.given(case)
        effect = next(iter(case.effects))
        yield Subject(
            name=f"{'beyond' if index % 2 else 'within'} {case.index}",
            recording=given.recording,
            machine=given.drive,
            mode=None,
            truth=effect,
            posed=is_posed(effect),
            seen=case.judgeable,
        )


def on_disk(folder: Path) -> Iterator[Subject]:
    """Recordings of real machines, one per folder that has a drive file of kind `rigid`."""
    for path in sorted(one for one in folder.iterdir() if (one / "drive.yaml").is_file()):
        machine = load_machine(path / "drive.yaml")
        if machine.kind != "rigid" or machine.actuation == "loop":
            continue
        truth = yaml.safe_load((path / "truth.yaml").read_text(encoding="utf-8"))
        source = path / truth["recording"]
        recording = load_stretch(source, load_map(path / "map.yaml"), LONGEST_S, lambda share: None)
        must = [one for group in truth["must"] for one in group[:1]]
        yield Subject(
            name=path.name,
            recording=recording,
            machine=machine,
            mode=truth.get("mode"),
            truth=" + ".join(must) or None,
            posed=bool(must) and all(is_posed(one) for one in must),
        )


def pose(subject: Subject) -> Posed:
    """The windows of a recording; InputError where it has none to fit and to judge."""
    motion = motion_of(subject.recording, subject.machine, subject.name, subject.mode)
    catalogue = Catalogue(motion, subject.machine)
    balance = Balance(motion, catalogue.nominal(), catalogue.model)
    begin = float(balance.time_s[balance.usable][0]) if balance.usable.any() else 0.0
    stretch = np.floor((motion.time_s - begin) / balance.stretch_s).astype(np.int64)
    least = max(8, int(0.5 * balance.stretch_s * motion.rate_hz))
    groups: tuple[list[tuple[int, int]], ...] = ([], [])
    for first, behind in pieces(motion.usable, stretch, least):
        inside = (motion.rows >= first) & (motion.rows < behind)
        if inside.any() and float(np.mean(balance.usable[inside])) >= _MOVES:
            groups[int(stretch[first] % HELD_OUT_EVERY == 1)].append((first, behind))
    if not all(groups):
        raise InputError(f"{subject.name}: no stretch in motion to fit, or none to judge")
    moved = motion.usable
    return Posed(
        motion=motion,
        balance=balance,
        catalogue=catalogue,
        scale=np.array([np.std(motion.raw_position[moved]), np.std(motion.velocity[moved])]),
        fitted=np.array(groups[0]),
        held_out=np.array(groups[1]),
    )


def _guessed(posed: Posed) -> tuple[float, float, float]:
    """A first value of an inertia that the file leaves out, and the range that guesses of it span.

    By least squares of the fitted samples' effort on acceleration, speed and its sign, position and
    a constant; and as if all the effort accelerated.
    """
    motion, rows = posed.motion, posed.balance.fitted
    speed = motion.velocity
    columns = [motion.acceleration, speed, np.sign(speed), motion.position, np.ones_like(speed)]
    made = motion.filtered(np.stack(columns))[:, rows].T
    effort = posed.balance.effort[rows]
    size = np.sqrt(np.mean(made**2, axis=0))
    regressed = float((np.linalg.lstsq(made / size, effort, rcond=None)[0] / size)[0])
    most = float(np.std(effort) / np.std(made[:, 0]))
    start = regressed if 0.0 < regressed < most else most
    return start, start, most


def problem_of(posed: Posed) -> tuple[dict[str, Any], bool]:
    """What `mujoco_joint.Problem` holds, and whether the file alone gives a machine to simulate."""
    motion, model = posed.motion, posed.catalogue.model
    usable = motion.usable
    effort = float(np.quantile(np.abs(motion.effort[usable]), 0.995))
    speed = float(np.quantile(np.abs(motion.velocity[usable]), 0.995))
    travel = float(np.ptp(motion.position[usable]))
    middle = float(np.median(motion.position[usable]))
    inertia, known = model.inertia, model.inertia is not None
    least = most = inertia
    if inertia is None:
        inertia, least, most = _guessed(posed)
    start = np.array(
        [
            inertia,
            float(np.mean(model.viscous)),
            float(np.mean(model.coulomb)),
            model.stiffness,
            -model.constant - model.stiffness * middle,
        ]
    )
    spans = _ROOM * np.array([effort / speed, effort, effort / travel, effort])
    high = np.maximum([_REACH * most, *spans], 2.0 * np.abs(start))
    low = np.array([least / _REACH, 0.0, 0.0, 0.0, -high[4]])
    problem = {
        "linear": posed.catalogue.machine.linear,
        "rate_hz": motion.rate_hz,
        "effort": motion.effort,
        "position": motion.raw_position,
        "velocity": motion.velocity,
        "smooth_position": motion.position,
        "acceleration": motion.acceleration,
        "fitted": posed.fitted,
        "held_out": posed.held_out,
        "scale": posed.scale,
        "start": start,
        "low": low,
        "high": high,
        "springref": middle,
    }
    return problem, known
