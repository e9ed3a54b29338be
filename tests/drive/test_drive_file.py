"""Drive files: what is read, and what is refused by name."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from ecyl_ros.drive.drive_file import (
    drive_from_flat,
    drive_to_flat,
    load_drive,
    profiles,
    read_parameter_file,
)
from ecyl_ros.drive.packed import pack
from ecyl_ros.drive.stability import check_stability
from ecyl_ros.errors import InputError

SHARED = Path(__file__).parents[3] / "shared"


def _flat() -> dict:
    return drive_to_flat(load_drive("bench"))


def test_profiles_hold_table_2_and_the_rates() -> None:
    """Profiles paper and si are Table 2 and differ in the stiffness unit alone, by 60 x 180/pi."""
    assert profiles() == ["bench", "paper", "servo_1khz", "si", "worn_1khz"]
    paper, si = load_drive("paper"), load_drive("si")
    unit = 60 * 180 / math.pi
    for soft, hard, slope in zip(
        paper.transmission.stiffness, si.transmission.stiffness, (0.529, 0.348), strict=True
    ):
        assert soft == pytest.approx(1 / slope, rel=1e-6)
        assert hard == pytest.approx(soft * unit, rel=1e-6)
    same = dataclasses.replace(si.transmission, stiffness=paper.transmission.stiffness)
    assert dataclasses.replace(si, transmission=same) == paper
    assert paper.transmission.backlash == pytest.approx(math.radians(20.15 / 60), rel=1e-6)
    assert (paper.controller.rate, load_drive("servo_1khz").controller.rate) == (1e5, 1e3)


@pytest.mark.skipif(not SHARED.is_dir(), reason="the folder shared is not beside the repository")
def test_the_nominal_model_of_the_recordings_is_read_as_it_is() -> None:
    """`drives/bench.yaml`, which others rely on, loads with every value it holds."""
    path = SHARED / "drives" / "bench.yaml"
    drive = load_drive(path)
    flat = drive_to_flat(drive)
    for key, value in read_parameter_file(path).items():
        assert flat[key] == value


COUPLING = ("backlash", "stiffness", "contact_damping")


def test_a_coupling_that_is_left_out_is_rigid_for_the_loop() -> None:
    """Its resonance lies at the control rate in rad/s, half damped; the loop stays stable, and the
    file is written out as it came."""
    for name in ("bench", "servo_1khz"):
        stated = drive_to_flat(load_drive(name))
        flat = {key: v for key, v in stated.items() if key.split(".")[-1] not in COUPLING}
        drive = drive_from_flat(flat, "f")
        rotor, load = drive.motor.rotor_inertia, drive.load.inertia
        reduced, coupling = rotor * load / (rotor + load), drive.transmission
        assert math.sqrt(coupling.stiffness[0] / reduced) == pytest.approx(drive.controller.rate)
        ratio = coupling.contact_damping / (2.0 * math.sqrt(coupling.stiffness[0] * reduced))
        assert ratio == pytest.approx(0.5) and coupling.backlash == 0.0
        check_stability(drive, "f")
        assert drive_to_flat(drive) == flat
    with pytest.raises(InputError, match=r"^f: load.inertia is missing"):
        drive_from_flat({key: v for key, v in flat.items() if key != "load.inertia"}, "f")


def test_flat_form_returns_the_same_drive() -> None:
    """Writing a drive out as parameters and reading them back changes nothing."""
    for name in profiles():
        drive = load_drive(name)
        assert drive_from_flat(drive_to_flat(drive), "again") == drive


@pytest.mark.parametrize(
    ("key", "value", "expected"),
    [
        ("transmission.lead", 20.0, "transmission.lead = 20 m/rev"),  # millimetres
        ("motor.inductance", 2.26, "motor.inductance = 2.26 H"),  # millihenries
        ("motor.rotor_inertia", 0.0, "motor.rotor_inertia"),
        ("motor.rotor_inertia", -1e-4, "motor.rotor_inertia"),
        ("motor.resistance", float("nan"), "motor.resistance"),
        ("motor.resistance", "much", "motor.resistance = 'much'"),
        ("motor.resistance", True, "motor.resistance = True"),
        ("motor.pole_pairs", 2.5, "a whole number"),
        ("transmission.stiffness", [], "transmission.stiffness has 0 values"),
        ("transmission.stiffness", [1.0, 2.0], "stiffness_breaks has 0 values, expected 1"),
        ("transmission.stiffness", [-1.0], "transmission.stiffness"),
        ("transmission.backlash", -1e-3, "transmission.backlash"),
        ("controller.feedback", "load", "expected rotor or rod"),
        ("controller.form", "pid", "expected parallel or series"),
        ("controller.rate", 0.0, "controller.rate"),
        ("controller.current_limit", 0.0, "above 0"),
        ("controller.position.kp", -1.0, "controller.position.kp"),
        ("limits.stroke_min", 1.0, "limits.stroke_min"),
        ("telemetry_rate", 0.0, "telemetry_rate"),
    ],
)
def test_impossible_values_are_refused_by_name(key: str, value, expected: str) -> None:
    """One line that names the source, the key and what was expected."""
    with pytest.raises(InputError) as caught:
        drive_from_flat(_flat() | {key: value}, "file.yaml")
    message = str(caught.value)
    assert message.startswith("file.yaml: ")
    assert expected in message
    assert "expected" in message and "\n" not in message


def test_unknown_and_missing_keys_are_named() -> None:
    """A misspelt key is refused with the one meant; a missing one with its unit."""
    with pytest.raises(InputError, match=r"unknown key motor\.resistence; did you mean motor\.res"):
        drive_from_flat(_flat() | {"motor.resistence": 1.0}, "f")
    with pytest.raises(InputError, match="unknown key wheels"):
        drive_from_flat(_flat() | {"wheels": 4}, "f")
    short = _flat()
    del short["motor.inductance"]
    with pytest.raises(InputError, match=r"motor\.inductance is missing.*H"):
        drive_from_flat(short, "f")


def test_breaks_must_increase() -> None:
    """Stiffness breaks out of order are refused."""
    changes = {
        "transmission.stiffness": [1.0, 2.0, 3.0],
        "transmission.stiffness_breaks": [5.0, 4.0],
    }
    with pytest.raises(InputError, match="increasing torques"):
        drive_from_flat(_flat() | changes, "f")


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", "no 'ros__parameters'"),
        ("a: [1", "not YAML"),
        ("- 1\n- 2\n", "no 'ros__parameters'"),
        ("/**:\n  ros__parameters: 7\n", "no 'ros__parameters'"),
        ("/ns:\n  node:\n    ros__parameters: {a: 1}\n", "below namespace /ns"),
        ("\x00\x01", "not YAML"),
    ],
)
def test_files_that_are_no_parameter_files(tmp_path: Path, text: str, expected: str) -> None:
    """Anything else than a ROS 2 parameter file is refused by one line with its path."""
    path = tmp_path / "d.yaml"
    path.write_text(text)
    with pytest.raises(InputError, match=expected) as caught:
        load_drive(path)
    assert str(path) in str(caught.value) and "\n" not in str(caught.value)


def test_a_missing_file_names_the_profiles() -> None:
    """A path that does not exist is refused with the profiles there are."""
    with pytest.raises(InputError, match="servo_1khz"):
        load_drive("nowhere.yaml")


@settings(max_examples=300, deadline=None)
@given(st.data())
def test_mutated_files_never_end_in_a_traceback(data) -> None:
    """Whatever bytes replace parts of a drive file, it loads or is refused by InputError."""
    import tempfile

    text = yaml.safe_dump({"/**": {"ros__parameters": _flat()}}).encode()
    begin = data.draw(st.integers(0, len(text) - 1))
    length = data.draw(st.integers(0, 12))
    text = text[:begin] + data.draw(st.binary(max_size=12)) + text[begin + length :]
    with tempfile.NamedTemporaryFile(suffix=".yaml") as file:
        file.write(text)
        file.flush()
        try:
            pack(load_drive(file.name))
        except InputError as error:
            assert "\n" not in str(error)


def test_nested_aliases_are_refused_at_once(tmp_path) -> None:
    """Nine levels of nine aliases would be 387 million parameters: one line instead."""
    lines = ["/**:", "  ros__parameters:", "    a0: &a0 {x: 1.0}"]
    for level in range(1, 10):
        inner = ", ".join(f"k{index}: *a{level - 1}" for index in range(9))
        lines.append(f"    a{level}: &a{level} {{{inner}}}")
    path = tmp_path / "laughs.yaml"
    path.write_text("\n".join(lines), encoding="utf-8")
    with pytest.raises(InputError, match=r"laughs\.yaml: a YAML alias"):
        load_drive(path)
