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
its name; the toolbox has no such question. `closest` is therefore judged, too: the set of effects
of the diagnosis that fits best, named or not.

Machines are drawn by the study of rigid drives (`ecyl blind --drives rigid`), as far as MuJoCo can
pose them: their effort is recorded. Half of them have a cause that is one of the joint's
parameters, half one that is not. With `--recordings DIR` recordings of real machines come after
them: each a folder with drive.yaml, map.yaml, truth.yaml (`recording`: the file beside it, `mode`,
`must`: causes known to be there) and the recording.
"""

from __future__ import annotations

import json
import subprocess
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from mujoco_joint import PARAMETERS
from report import ROOT, Report, parser
from sysid_posing import PLANNED, Posed, Subject, drawn, on_disk, pose, problem_of
from sysid_table import agreement, count, show, told

from ecyl_ros.drive.rigid.driven import Pieces, by_effort
from ecyl_ros.drive.rigid.machine import Machine
from ecyl_ros.drive.rigid.packed import model_of
from ecyl_ros.errors import InputError
from ecyl_ros.gap.diagnose import diagnose
from ecyl_ros.gap.rigid.closest import closest
from ecyl_ros.gap.rigid.diagnose import judged as competed
from ecyl_ros.gap.rigid.terms import Catalogue

LIMIT_S = 1800.0  # for one fit of the toolbox


class PeerError(Exception):
    """The toolbox gave no answer; the message says why."""


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


def closest_set(subject: Subject, posed: Posed) -> Machine:
    """The machine with the set of effects that came closest, whether or not it earned its name."""
    found = competed(posed.motion, subject.machine, (), subject.name, lambda _: None)
    return closest(found.catalogue.along, found.contest.winner)


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
        "closest": twin_errors(posed, closest_set(subject, posed)),
    }


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
    if not 0 <= options.cases <= PLANNED:
        flags.error(f"--cases {options.cases}: expected 0 to {PLANNED}")
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
