"""The public interface: `import ecyl_ros as ec`."""

from __future__ import annotations

import inspect
import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import ecyl_ros as ec
from ecyl_ros.cli.main import main

ROOT = Path(__file__).parents[2]
WORN = ROOT / "bags" / "worn_drive.mcap"
RIGID = """/**:
  ros__parameters:
    drive: {kind: rigid, output: linear}
    actuation: {signal: current, gain: 486.0}
"""
# What scripts and notebooks of users lean on. A line, or a keyword with a default, may be added;
# none may change.
STABLE = """
analyse(recording, skip_s=0.0, *, rotor_to_rod_m_per_rad=None, emd_settings=None, line_hz=None)
changed(drive, values)
diagnose(recording, drive, signal_map=None, *, begin_s=None, end_s=None, mode=None, without=(), \
progress=None)
load_drive(name)
profiles()
propose_map(path)
read(path, signal_map=None, *, begin_s=None, end_s=None)
simulate(drive, reference, duration_s=None, *, progress=None)
write(recording, path, *, overwrite=False)
""".strip().splitlines()
OF_A_RESULT = (
    *("verdict", "block", "signals", "causes", "sheet", "measured", "notes", "shrink", "closes"),
    *("sentence", "plot", "to_dict", "write_json", "write_report", "write_mcap", "write_drive"),
)
OF_A_RECORDING = ("stamp_ns", "time_s", "rate_hz", "duration_s", "has", "signal", "slice", "notes")


@pytest.fixture(scope="module")
def recording() -> ec.Recording:
    """The worn drive's example recording."""
    return ec.read(WORN)


@pytest.fixture(scope="module")
def rigid(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A drive file of a rigid drive, whose diagnosis takes a moment."""
    path = tmp_path_factory.mktemp("drive") / "rigid.yaml"
    path.write_text(RIGID, encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def found(recording: ec.Recording, rigid: Path) -> ec.DiagnosisResult:
    """What a diagnosis of it gives."""
    return ec.diagnose(recording, rigid)


def _plain(name: str) -> str:
    """Name and parameters of a function, without annotations."""
    signature = inspect.signature(getattr(ec, name))
    bare = [
        one.replace(annotation=inspect.Parameter.empty) for one in signature.parameters.values()
    ]
    return f"{name}{inspect.Signature(bare)}"


def test_the_public_names_are_those_promised() -> None:
    """Each public function has the parameters promised; every name has a docstring."""
    functions = [name for name in ec.__all__ if inspect.isfunction(getattr(ec, name))]
    assert [_plain(name) for name in functions] == STABLE
    for name in ec.__all__:
        assert inspect.getdoc(getattr(ec, name)), name
        assert name in dir(ec)
    for name in OF_A_RESULT:
        assert (
            hasattr(ec.DiagnosisResult, name)
            or name in ec.DiagnosisResult.__annotations__
            or (name in ec.DiagnosisResult.__dataclass_fields__)
        ), name
    for name in OF_A_RECORDING:
        assert hasattr(ec.Recording, name) or name in ec.Recording.__dataclass_fields__, name
    with pytest.raises(AttributeError, match="no_such"):
        _ = ec.no_such


def test_the_import_is_light() -> None:
    """`import ecyl_ros` alone imports neither numpy nor anything else of weight."""
    program = "import sys, ecyl_ros; print('numpy' in sys.modules, 'scipy' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.stdout.split() == ["False", "False"], done.stderr


def test_a_recording_goes_to_pandas_and_back(recording: ec.Recording) -> None:
    """Stamps to the ns, every signal to the last bit, and what is known of it, survive."""
    frame = recording.to_pandas()
    back = ec.Recording.from_pandas(frame)
    assert np.array_equal(back.stamp_ns, recording.stamp_ns)
    for name in frame.columns.drop("stamp_ns"):
        assert np.array_equal(back.signal(name), recording.signal(name), equal_nan=True), name
    assert back.notes == recording.notes and dict(back.resolution) == dict(recording.resolution)
    part = frame.loc[2.0:3.0]
    assert len(ec.Recording.from_pandas(part)) == len(part)


def test_frames_of_other_people_make_recordings() -> None:
    """Instants may be seconds, dates or time spans; what cannot be meant is refused by name."""
    seconds = np.arange(5) * 1e-3
    column = {"rod_position_m": np.arange(5.0), "remark": list("abcde")}
    dates = pd.Timestamp("2026-05-04") + pd.to_timedelta(seconds, unit="s")
    for index in (seconds, pd.to_timedelta(seconds, unit="s"), dates):
        made = ec.Recording.from_pandas(pd.DataFrame(column, index=index))
        assert np.allclose(made.time_s, seconds, atol=1e-12) and made.has("rod_position_m")
    for frame, said in (
        (pd.DataFrame({"x": [1.0]}), "no column"),
        (pd.DataFrame({"mode": ["a", "b"]}), "mode holds no numbers"),
        (pd.DataFrame({"mode": [1, 2]}, index=["a", "b"]), "no time"),
        (pd.DataFrame({"mode": [1, 2]}, index=[1.0, 1.0]), "do not increase"),
        (pd.DataFrame({"mode": [1, 2]}, index=[1.0, np.nan]), "missing"),
    ):
        with pytest.raises(ec.InputError, match=said):
            ec.Recording.from_pandas(frame)


def test_memory_and_file_are_diagnosed_alike(found: ec.DiagnosisResult, rigid: Path) -> None:
    """A recording in memory gets the diagnosis of its file."""
    own, other = found.to_dict(), ec.diagnose(WORN, rigid).to_dict()
    for one in (own, other):
        one.pop("seconds"), one.pop("recording")
    assert own == other and own["schema"] == "ecyl.diagnosis/1"


def test_what_a_machine_surely_has_not_is_left_out(
    found: ec.DiagnosisResult, recording: ec.Recording, rigid: Path
) -> None:
    """`without`: the cause that was found is not named, and a note says why."""
    names = [one.effect for one in found.causes]
    other = ec.diagnose(recording, rigid, without=names)
    assert names and not set(names) & {one.effect for one in other.causes}
    assert any("did without" in note and names[0] in note for note in other.notes)


def test_a_diagnosis_shows_itself(found: ec.DiagnosisResult, tmp_path: Path) -> None:
    """Notebook and print have the sentence and every cause; pictures and files are written."""
    shown = found._repr_html_()
    assert found.causes and found.verdict in repr(found)
    for one in found.causes:
        assert one.effect in repr(found)
    assert " ".join(str(found).split()).startswith(found.sentence[:60])
    assert shown.count("<table>") >= 2 and "<script" not in shown
    picture = found.plot()
    assert len(picture.axes) >= 1 and picture._repr_png_().startswith(b"\x89PNG")
    found.write_report(tmp_path / "d.html")
    found.write_drive(tmp_path / "twin.yaml")
    assert ec.load_drive(tmp_path / "twin.yaml") != ec.load_drive(found.drive_file)


def test_a_model_without_a_file_is_told_so(found: ec.DiagnosisResult, tmp_path: Path) -> None:
    """A twin is written from a file only; without one the error says what to give."""
    import dataclasses

    with pytest.raises(ec.InputError, match="came from no file"):
        dataclasses.replace(found, drive_file=None).write_drive(tmp_path / "twin.yaml")


def test_simulate_gives_what_the_command_records(tmp_path: Path) -> None:
    """`ec.simulate` and `ecyl simulate` write the same bytes; a reference can be played again."""
    spec = "sine:amplitude=1e-3,frequency=1"
    run = ["--reference", spec, "--duration", "0.5", "--out", str(tmp_path / "command.mcap")]
    assert main(["simulate", "--drive", "bench", *run]) == 0
    made = ec.simulate("bench", spec, 0.5)
    ec.write(made, tmp_path / "python.mcap")
    assert (tmp_path / "python.mcap").read_bytes() == (tmp_path / "command.mcap").read_bytes()
    ec.write(made, tmp_path / "python.csv")
    assert np.array_equal(ec.read(tmp_path / "python.csv").rod_position_m, made.rod_position_m)
    again = ec.simulate(ec.load_drive("bench"), made)
    assert len(again) == len(made)
    with pytest.raises(ec.InputError, match="exists"):
        ec.write(made, tmp_path / "python.csv")
    with pytest.raises(ec.InputError, match="duration_s is missing"):
        ec.simulate("bench", spec)


def test_values_of_a_drive_are_changed_by_key() -> None:
    """`changed` takes constants and effects by their keys, refuses others, and leaves the first."""
    bench = ec.load_drive("bench")
    half = 0.5 * bench.transmission.backlash
    cogging = {"amplitude_nm": 0.05, "periods_per_rev": 24.0}
    keys = {f"effects.cogging_torque.{name}": value for name, value in cogging.items()}
    other = ec.changed(bench, {"transmission.backlash": half, **keys})
    assert other.transmission.backlash == half != bench.transmission.backlash
    assert cogging.items() <= other.effects["cogging_torque"].items()
    with pytest.raises(ec.InputError, match=r"did you mean transmission\.backlash"):
        ec.changed(bench, {"transmission.backlsh": half})
