"""A recording longer than is judged at once: which stretches are picked, and what is said."""

from __future__ import annotations

import dataclasses
import itertools
from pathlib import Path

import numpy as np
import pytest

from ecyl_ros.drive.drive_file import config_folder, load_drive
from ecyl_ros.drive.engine import simulate
from ecyl_ros.drive.parameters import DriveParameters
from ecyl_ros.drive.reference.moves import Moves
from ecyl_ros.drive.telemetry import simulation_recording
from ecyl_ros.errors import InputError
from ecyl_ros.gap.diagnosis import Diagnosis
from ecyl_ros.gap.long_run import diagnose_long
from ecyl_ros.gap.report.page import report_html
from ecyl_ros.gap.report.terminal import summary
from ecyl_ros.recording.load import LongRecording, load_long, load_recording
from ecyl_ros.recording.signals import SIGNALS, Recording
from ecyl_ros.recording.writer import write_recording

STRETCH_S = 4.0
HALF_S = 13.0
FAULT = {"rotor_coulomb_friction": {"coulomb_nm": 0.12}}


def drive() -> DriveParameters:
    """The bench drive."""
    return load_drive(config_folder() / "bench.yaml")


def run(seconds: float, effects: dict[str, dict[str, float]], seed: int, moving: bool) -> Recording:
    """Moves of the bench drive with effects, or rest."""
    nominal = drive()
    machine = dataclasses.replace(
        nominal,
        effects=effects,
        sensors=dataclasses.replace(nominal.sensors, noise_seed=seed),
    )
    moves = Moves((0.01, -0.004, 0.006, 0.0), 0.06, 1.0, 50.0, dwell=0.3)
    rate = machine.sample_rate
    made = simulate(machine, lambda i: moves.sample(i / rate) if moving else (0.0, 0.0), seconds)
    return simulation_recording(made, machine)


def chained(*parts: Recording) -> Recording:
    """Recordings one after the other; each begins at rest at 0."""
    shift, stamps = 0, []
    for part in parts:
        stamps.append(part.stamp_ns + shift)
        shift = int(stamps[-1][-1]) + 1_000_000
    signals = {name: np.concatenate([part.signal(name) for part in parts]) for name in SIGNALS}
    return Recording(stamp_ns=np.concatenate(stamps), **signals)


@pytest.fixture(scope="module")
def half_faulty(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """20 s of a healthy drive, 10 s of rest, then 20 s with friction."""
    path = tmp_path_factory.mktemp("long") / "half.mcap"
    healthy = run(HALF_S, {}, 1, moving=True)
    rest = run(10.0, {}, 2, moving=False)
    write_recording(chained(healthy, rest, run(HALF_S, FAULT, 3, moving=True)), path)
    return path


def opened(path: Path, most: int) -> LongRecording:
    """The recording by its stretches."""
    found = load_long(path, None, STRETCH_S, most)
    assert isinstance(found, LongRecording)
    return found


@pytest.fixture(scope="module")
def diagnosis(half_faulty: Path) -> Diagnosis:
    """What is said of it."""
    shares: list[float] = []
    found = diagnose_long(
        opened(half_faulty, 8),
        drive(),
        source=str(half_faulty),
        drive_name="bench",
        progress=shares.append,
    )
    assert shares == sorted(shares) and shares[-1] == pytest.approx(1.0)
    return found


def test_a_fault_of_the_second_half_is_found_and_placed_there(diagnosis: Diagnosis) -> None:
    """Friction that only the second half has is named, with its size; the first half has no gap."""
    assert [one.effect for one in diagnosis.causes] == ["rotor_coulomb_friction"]
    (size,) = [p for p in diagnosis.causes[0].parameters if p.name == "coulomb_nm"]
    assert size.value == pytest.approx(0.12, rel=0.03)
    first = [one for one in diagnosis.stretches if one.end_s <= HALF_S]
    second = [one for one in diagnosis.stretches if one.begin_s >= HALF_S + 10.0]
    assert len(first) >= 2 and len(second) >= 2
    assert not any(one.gap for one in first)
    assert all(one.gap and one.before > 2.0 and one.after < 1.3 for one in second)
    # With the friction added, the model no longer fits what has none.
    assert all(one.after > 2.0 * one.before for one in first)
    assert [one.begin_s >= HALF_S for one in diagnosis.stretches if one.judged] == [True]


def test_the_stretches_are_stated_in_terminal_json_and_report(diagnosis: Diagnosis) -> None:
    """Which stretch was judged, and that the gap is not there all the time, stands in all three."""
    judged = next(one for one in diagnosis.stretches if one.judged)
    text, page, data = summary(diagnosis), report_html(diagnosis), diagnosis.as_json()
    said = f"judged from {judged.begin_s:.1f} s to {judged.end_s:.1f} s"
    for where in (text, page, " ".join(data["notes"])):
        assert said in where
        assert "the gap is not there all the time" in where
    assert [one["judged"] for one in data["stretches"]].count(True) == 1
    assert len(data["stretches"]) == len(diagnosis.stretches)
    assert "Over the whole recording" in page
    assert page.count("no gap") >= sum(not one.gap for one in diagnosis.stretches)


def test_a_bag_read_in_pieces_gives_the_stretches_of_one_read_whole(
    half_faulty: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The same stretches, sample for sample, none of them overlapping and none of them rest."""
    whole = opened(half_faulty, 8)
    monkeypatch.setattr("ecyl_ros.recording.load.WHOLE_BYTES", 0)
    shares: list[float] = []
    streamed = load_long(half_faulty, None, STRETCH_S, 8, shares.append)
    assert isinstance(streamed, LongRecording)
    assert shares and shares == sorted(shares) and 0.0 < shares[-1] <= 1.0
    chosen = streamed.stretches.chosen
    assert chosen == whole.stretches.chosen
    times = sorted((one.begin_s, one.end_s) for one in chosen)
    assert all(end <= begin + 1e-9 for (_, end), (begin, _) in itertools.pairwise(times))
    recording = load_recording(half_faulty)
    for one in chosen:
        part = streamed.read(one)
        expected = whole.read(one)
        assert len(part) == 4000 and np.array_equal(part.stamp_ns, expected.stamp_ns)
        reference = recording.slice(one.begin_s, one.end_s).reference_position_m
        assert np.ptp(reference) > 0.005
        assert np.array_equal(part.reference_position_m, reference)


def test_a_drive_file_of_another_machine_is_refused_of_a_long_recording_too(
    half_faulty: Path,
) -> None:
    """Where no stretch can be judged, the reason of the best one is given."""
    nominal = drive()
    lead = dataclasses.replace(nominal.transmission, lead=nominal.transmission.lead * 5.0)
    with pytest.raises(InputError, match="belongs to another machine"):
        diagnose_long(
            opened(half_faulty, 3),
            dataclasses.replace(nominal, transmission=lead),
            source="half",
            drive_name="other",
        )
