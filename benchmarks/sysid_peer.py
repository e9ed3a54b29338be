"""The diagnosis of rigid drives beside MuJoCo's system-identification toolbox (`mujoco.sysid`).

Both are given the same recording and the same drive file and fit on the same stretches: two of
three, as the diagnosis divides a recording. The toolbox fits a joint of MuJoCo (inertia, damping,
frictionloss, stiffness and the actuator's bias) from there, each fitted stretch a window begun at
the measured state, in an environment of its own. What it minimises is what motion is judged by.
Both are judged on the third stretches:

- motion: simulated from the measured state of each stretch on, driven by the recorded effort; the
  joint by MuJoCo, the diagnosis' twin by its own replay. RMS of position and speed less the
  recorded, each over the standard deviation of what was recorded, the two pooled.
- effort: what the recorded motion asks for less the recorded effort, RMS over RMS of the effort,
  both through the same low-pass.

No value of either was fitted to a held-out stretch. The diagnosis asks there whether a cause earns
its name; the toolbox has no such question.

Machines are drawn by the study of rigid drives (`ecyl blind --drives rigid`), as far as MuJoCo can
pose them: their effort is recorded. Half of them have a cause that is one of the joint's
parameters, half one that is not. With `--recordings DIR` recordings of real machines come after
them: each a folder with drive.yaml, map.yaml, truth.yaml (`recording`: the file beside it, `mode`,
`must`: causes known to be there) and the recording.
"""

from __future__ import annotations

import json
import math
import statistics
import subprocess
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from mujoco_joint import PARAMETERS
from report import ROOT, Report, parser

from ecyl_ros.drive.rigid.driven import Pieces, by_effort, pieces
from ecyl_ros.drive.rigid.machine import Machine
from ecyl_ros.drive.rigid.machine_file import load_machine
from ecyl_ros.drive.rigid.packed import model_of
from ecyl_ros.errors import InputError
from ecyl_ros.gap.diagnose import diagnose
from ecyl_ros.gap.rigid.balance import HELD_OUT_EVERY, Balance
from ecyl_ros.gap.rigid.motion import Motion, motion_of
from ecyl_ros.gap.rigid.terms import Catalogue
from ecyl_ros.gap.screen import LONGEST_S
from ecyl_ros.gap.study.drives import Choice, RigidDrives
from ecyl_ros.recording.load import load_stretch
from ecyl_ros.recording.map import load_map
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
LIMIT_S = 1800.0  # for one fit of the toolbox
_MOVES = 0.5  # share of a window that has to be in motion
_REACH = 10.0  # times the inertia that the fit begins with, either way: its bounds
_ROOM = 3.0  # times what would take all the effort: bounds of the rest
_PLANNED = 200  # cases of either side, whatever is asked for: the first are always the same


class PeerError(Exception):
    """The toolbox gave no answer; the message says why."""


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
        iter(drives.plan(_PLANNED, seed, Choice(("single",), effects)))
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


def peer(python: Path, problem: dict[str, Any]) -> dict[str, Any]:
    """The toolbox's answer: what it printed, and the arrays of its answer."""
    with tempfile.TemporaryDirectory() as folder:
        asked, answered = Path(folder, "problem.npz"), Path(folder, "answer.npz")
        np.savez(asked, **problem)
        script = str(Path(__file__).with_name("mujoco_joint.py"))
        command = [str(python), script, str(asked), str(answered)]
        try:
            done = subprocess.run(
                command, capture_output=True, text=True, check=False, timeout=LIMIT_S
            )
        except (OSError, subprocess.TimeoutExpired) as error:
            raise PeerError(str(error)) from None
        if done.returncode:
            raise PeerError((done.stderr.strip().splitlines() or ["no output"])[-1])
        with np.load(answered) as held:
            arrays = {name: held[name] for name in held.files}
    return json.loads(done.stdout.splitlines()[-1]) | arrays


def twin_errors(posed: Posed, machine: Machine) -> dict[str, float | None]:
    """Errors of a machine of ours; of its motion None where its inertia is unknown."""
    catalogue = Catalogue(posed.motion, machine)
    errors: dict[str, float | None] = {"effort": posed.effort_error(catalogue.nominal())}
    own = catalogue.units.own
    if not (model_of(machine, own).inertia or 0.0) > 0.0:
        return errors | {"motion": None}
    parts = Pieces(posed.held_out[:, 0], posed.held_out[:, 1])
    still = np.zeros(posed.motion.time_s.size)
    with np.errstate(all="ignore"):
        made = by_effort(posed.motion, machine, own, parts, still)
    return errors | {"motion": posed.motion_error(made.position, made.velocity)}


def judged(subject: Subject, python: Path) -> dict[str, Any]:
    """One row: errors of the file's machine, the toolbox and the diagnosis, and what they say."""
    posed = pose(subject)
    begin = time.perf_counter()
    diagnosis = diagnose(subject.recording, subject.machine, mode=subject.mode, source=subject.name)
    ours_s = time.perf_counter() - begin
    problem, known = problem_of(posed)
    answer = peer(python, problem)
    nominal = twin_errors(posed, subject.machine) if known else {"effort": None, "motion": None}
    other = {
        "motion": posed.motion_error(*answer["motion_start"].T),
        "effort": posed.effort_error(answer["effort_start"]),
    }
    return {
        "machine": subject.name,
        "truth": subject.truth,
        "truth_is_a_parameter": subject.posed if subject.truth else None,
        "truth_can_be_seen": subject.seen,
        "windows_fitted": len(posed.fitted),
        "windows_held_out": len(posed.held_out),
        "nominal": nominal,
        "nominal_by_mujoco": other if known else None,
        "peer": {
            "motion": posed.motion_error(*answer["motion"].T),
            "effort": posed.effort_error(answer["effort"]),
            "values": dict(zip(PARAMETERS, answer["values"].tolist(), strict=True)),
            "seconds": answer["seconds"],
            "rms_start": answer["rms_start"],
            "rms_fitted": answer["rms_fitted"],
            "mujoco": answer["mujoco"],
        },
        "ours": {
            **twin_errors(posed, diagnosis.judged),
            "verdict": diagnosis.verdict,
            "causes": [one.effect for one in diagnosis.causes],
            "seconds": ours_s,
        },
    }


def told(row: dict[str, Any]) -> list[str]:
    """What both say of a machine, one line each."""
    ours, peer_s = row["ours"], row["peer"]["values"]
    truth = row["truth"] or "not known"
    if row["truth_is_a_parameter"] is False:
        truth += ", none of the joint's parameters"
    if row["truth_can_be_seen"] is False:
        truth += ", too small to be told in this recording"
    numbers = ", ".join(f"{name} {value:.4g}" for name, value in peer_s.items())
    causes = ", ".join(ours["causes"]) or "no cause named"
    return [
        f"  {row['machine']}: {truth}",
        f"    mujoco.sysid: {numbers}",
        f"    ours: {ours['verdict']}; {causes}",
    ]


def at_most(rows: list[dict[str, Any]], what: str) -> tuple[int, int, float]:
    """On how many rows our error is at most the peer's, of how many; median of ours over its."""
    pairs = [(row["ours"][what], row["peer"][what]) for row in rows]
    pairs = [(math.inf if one is None else one, other) for one, other in pairs]
    ratios = [one / other for one, other in pairs]
    return sum(one <= other for one, other in pairs), len(pairs), statistics.median(ratios)


def show(report: Report, rows: list[dict[str, Any]]) -> None:
    """The table of some machines, what was said of them, and the counts."""

    def cell(value: float | None) -> str:
        return "-" if value is None else f"{value:.4f}" if value < 100.0 else f"{value:.1e}"

    header = ["", "motion: file", "mujoco.sysid", "ours", "effort: file", "mujoco.sysid", "ours"]
    cells = [
        [
            row["machine"] + ("" if row["truth_is_a_parameter"] in (True, None) else " *"),
            *(cell(row[one]["motion"]) for one in ("nominal", "peer", "ours")),
            *(cell(row[one]["effort"]) for one in ("nominal", "peer", "ours")),
            f"{row['peer']['seconds']:.1f}",
            f"{row['ours']['seconds']:.1f}",
        ]
        for row in rows
    ]
    report.say("")
    report.table([*header, "its s", "our s"], cells)


def count(report: Report, key: str, rows: list[dict[str, Any]], meaning: str) -> None:
    """Print and keep on how many of some machines ours errs no more."""
    if not rows:
        return
    kept = {}
    for what in ("motion", "effort"):
        good, of, ratio = at_most(rows, what)
        report.say(
            f"  {meaning}, {what}: ours at most the peer's on {good} of {of}; "
            f"median of ours over the peer's {ratio:.3f}"
        )
        kept[what] = {"ours_at_most_the_peers": good, "of": of, "median_ratio": ratio}
    report.figures[key] = kept


def agreement(report: Report, rows: list[dict[str, Any]]) -> None:
    """How far errors of the file's own machine by MuJoCo are from those by our simulation."""
    known = [one for one in rows if one["nominal_by_mujoco"]]
    if not known:
        return
    apart = max(
        abs(one["nominal_by_mujoco"][what] / one["nominal"][what] - 1.0)
        for one in known
        for what in ("motion", "effort")
    )
    report.say(
        f"  MuJoCo {known[0]['peer']['mujoco']}; the file's machine, simulated and inverted by "
        f"both: its errors differ by {100.0 * apart:.1f} % at the most"
    )
    report.figures["nominal_differs"] = apart


def collect(report: Report, subjects: Iterator[Subject], python: Path) -> list[dict[str, Any]]:
    """Rows of all machines that both could be asked about; says which could not, and why."""
    rows = []
    for subject in subjects:
        try:
            rows.append(judged(subject, python))
            for line in told(rows[-1]):
                report.say(line)
        except (InputError, PeerError) as error:
            report.say(f"  {subject.name}: left out: {error}")
            report.figures.setdefault("left_out", {})[subject.name] = str(error)
    return rows


def main() -> None:
    """Run the benchmark."""
    flags = parser((__doc__ or "").splitlines()[0])
    flags.add_argument("--cases", type=int, default=12, help="machines drawn (default 12)")
    flags.add_argument("--seed", type=int, default=1, help="of the draw (default 1)")
    flags.add_argument("--recordings", type=Path, metavar="DIR", help="recordings of real machines")
    flags.add_argument(
        "--peers-python",
        type=Path,
        default=ROOT / ".venv-bench/bin/python",
        metavar="PYTHON",
        help="interpreter that has benchmarks/requirements.txt (default .venv-bench's)",
    )
    options = flags.parse_args()
    if not 0 <= options.cases <= _PLANNED:
        flags.error(f"--cases {options.cases}: expected 0 to {_PLANNED}")
    python = options.peers_python
    report = Report(
        f"rigid drives beside mujoco.sysid, {options.cases} machines, seed {options.seed}"
    )
    report.figures |= {"cases": options.cases, "seed": options.seed}
    if subprocess.run([python, "-c", "import mujoco.sysid"], check=False).returncode:
        report.say(f"  not measured: {python} has no mujoco.sysid")
        report.finish(options.json)
        return
    rows = collect(report, drawn(options.cases, options.seed), python)
    real = collect(report, on_disk(options.recordings), python) if options.recordings else []
    report.say("  held-out error, relative; *: the true cause is none of the joint's parameters")
    for part in filter(None, (rows, real)):
        show(report, part)
    agreement(report, [*rows, *real])
    posed = [one for one in rows if one["truth_is_a_parameter"]]
    count(report, "within", posed, "cause a parameter of the joint")
    count(report, "beyond", [one for one in rows if one not in posed], "cause none of them (*)")
    count(report, "drawn", rows, "all machines drawn")
    count(report, "real", real, "real recordings")
    report.figures |= {"machines": rows, "recordings": real}
    report.finish(options.json)


if __name__ == "__main__":
    main()
