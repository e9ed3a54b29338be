"""What a reader of each kind may make of a changed file: read it, or refuse it in one line."""

from __future__ import annotations

import json
import signal
from collections.abc import Callable
from pathlib import Path
from types import FrameType

import numpy as np

from ecyl_ros.drive.drive_file import load_drive
from ecyl_ros.drive.model_file import load_model
from ecyl_ros.drive.reference.spec import make_reference
from ecyl_ros.drive.rigid.machine_file import machine_from_flat
from ecyl_ros.errors import InputError
from ecyl_ros.export.joint_values import parameters, read_joint, rigid_file
from ecyl_ros.investigate.question import question
from ecyl_ros.plan.diagnosis_file import read_diagnosis
from ecyl_ros.plan.hypotheses import given, open_or_alike
from ecyl_ros.recording.check import check_map
from ecyl_ros.recording.load import load_recording
from ecyl_ros.recording.map import SignalMap
from ecyl_ros.recording.map_file import load_map, parse_map
from ecyl_ros.recording.mapped import read_mapped
from ecyl_ros.recording.propose import propose
from ecyl_ros.recording.survey import survey

SLOWEST_S = 10.0


class Hang(BaseException):
    """A reader took longer than `SLOWEST_S`; no `except Exception` may swallow it."""


def _read_bag(path: Path) -> None:
    proposal = propose(survey(path))
    if proposal.map is not None:
        read_mapped(path, proposal.map)
    if proposal.map is None or proposal.remarks == OWN:
        load_recording(path)


def _read_tables(path: Path) -> None:
    """A folder of tables, of which the second is whole."""
    (path.parent / "b.csv").write_text("t,enc\n" + "".join(f"{i},{i}\n" for i in range(60)))
    _read_bag(path.parent)


def _read_map(path: Path) -> None:
    """Check it against a table first, entry by entry; then read it, which may refuse it."""
    table = path.parent / "table.csv"
    if not table.exists():
        table.write_text("t,enc,x,q,f\n" + "".join(f"{i},{i},{i},{i},0\n" for i in range(60)))
    checked = check_map(table, path)
    assert not any("\n" in line or len(line) > 2000 for line in checked.lines())
    found = load_map(path)
    assert isinstance(found, SignalMap)


OWN = ("the topics are those of this project",)
_RATED = parse_map({"signals": {"rod_position": "q"}, "rate": 1000}, "rated")


def _read_mat(path: Path) -> None:
    proposal = propose(survey(path))
    read_mapped(path, proposal.map or _RATED)


def _read_metadata(path: Path) -> None:
    survey(path.parent)


def _read_motion(path: Path) -> None:
    """Read it, and ask the bench drive for it, which may refuse what is beyond its limits."""
    played = make_reference(str(path), load_drive("bench"), 2.0)
    assert np.isfinite([played.sample(time) for time in np.linspace(0.0, 2.0, 9)]).all()


def _read_joint(path: Path) -> None:
    found = read_joint(path, "rod")
    machine_from_flat(parameters(found), "joint")
    rigid_file(found, path.name)


def _read_diagnosis(path: Path) -> None:
    """All that `ecyl plan` and `ecyl investigate` ask of it."""
    data = read_diagnosis(path, load_drive("bench"), "bench")
    left = open_or_alike(data)
    for effect, values in left.values.items():
        given(effect, values)
    question(data)


READERS: dict[str, tuple[str, Callable[[Path], None]]] = {
    "mcap": ("a.mcap", _read_bag),
    "sqlite3": ("a.db3", _read_bag),
    "packed": ("a.mcap.zstd", _read_bag),
    "csv": ("a.csv", _read_bag),
    "tables": ("a.csv", _read_tables),
    "mat": ("a.mat", _read_mat),
    "drive": ("drive.yaml", lambda path: load_model(path) and None),
    "map": ("map.yaml", _read_map),
    "metadata": ("metadata.yaml", _read_metadata),
    "motion": ("motion.yaml", _read_motion),
    "joint": ("joint.xml", _read_joint),
    "diagnosis": ("diagnosis.json", _read_diagnosis),
}


def tried(kind: str, data: bytes, folder: Path) -> str:
    """`read` or `refused`; raises whatever else comes out of a reader, and `Hang`."""
    own = folder / kind
    own.mkdir(exist_ok=True)
    name, read = READERS[kind]
    path = own / name
    path.write_bytes(data)

    def late(number: int, frame: FrameType | None) -> None:
        raise Hang(f"{kind}: more than {SLOWEST_S:g} s of the processor")

    # By the processor's time: on a busy machine a good file can take long.
    before = signal.signal(signal.SIGPROF, late)
    signal.setitimer(signal.ITIMER_PROF, SLOWEST_S)
    try:
        read(path)
    except InputError as error:
        text = str(error)
        assert "\n" not in text and len(text) < 2000, json.dumps(text[:3000])
        return "refused"
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)
    return "read"
