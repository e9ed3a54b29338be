"""`ecyl inspect FILE --map M.yaml`: a map written by hand, checked entry by entry."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from foreign_bags import foreign_mcap

from ecyl_ros.cli.main import main
from ecyl_ros.recording.check import check_map

TIME = np.arange(1000) * 1e-3


def table(tmp_path: Path) -> Path:
    angle = np.sin(6.0 * TIME)
    random = np.random.default_rng(1)
    rows = "\n".join(
        f"{t:.3f},{1e3 * a:.4f},{-1e3 * a:.4f},{np.degrees(a):.4f},{i:.5f}"
        for t, a, i in zip(TIME, angle, random.normal(size=1000), strict=True)
    )
    (tmp_path / "a.csv").write_text(f"t,target_mm,slide_mm,motor [deg],iq\n{rows}\n")
    return tmp_path / "a.csv"


def written(tmp_path: Path, text: str) -> Path:
    (tmp_path / "m.yaml").write_text(text)
    return tmp_path / "m.yaml"


GOOD = """schema: ecyl.map/1
time: t
signals:
  reference_position: {field: target_mm, unit: mm}
  rod_position: {field: slide_mm, unit: mm, sign: -1, resolution: 0.0001}
  rotor_position: 'motor [deg]'
  current_q: iq
"""


def test_a_good_map_is_told_with_its_ranges_in_si(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Exit 0, and fields, SI units, ranges and steps are those of the columns."""
    path, own = table(tmp_path), written(tmp_path, GOOD)
    assert main(["inspect", str(path), "--map", str(own), "--json", str(tmp_path / "c.json")]) == 0
    data = json.loads((tmp_path / "c.json").read_text())
    assert (data["schema"], data["usable"], data["problems"]) == ("ecyl.map_check/1", True, [])
    signals = {one["name"]: one for one in data["signals"]}
    assert signals["rod_position"]["max"] == pytest.approx(np.sin(6.0 * TIME).max(), abs=1e-7)
    assert signals["rod_position"]["resolution"] == pytest.approx(1e-7)
    assert signals["rotor_position"]["max"] == pytest.approx(np.sin(6.0 * TIME).max(), abs=1e-5)
    assert (data["rate_hz"], data["duration_s"]) == (1000.0, pytest.approx(0.999))
    assert "motor [deg]" in capsys.readouterr().out


BAD = """schema: ecyl.map/1
time: t
signals:
  reference_position: {field: target, unit: mm}
  rod_position: {field: slide_mm, unit: furlong}
  rotor_position: {field: 'motor [deg]', unit: rad}
  rotor_velocty: iq
  current_q: {field: iq, sgn: -1}
  voltage_q: iq
speed: 3
"""


def test_every_mistake_is_told_with_its_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Missing column, unknown unit, conflict, names: one line each on stderr, exit 2."""
    path, own = table(tmp_path), written(tmp_path, BAD)
    assert main(["inspect", str(path), "--map", str(own)]) == 2
    told = capsys.readouterr()
    lines = told.err.strip().splitlines()
    for number, said in (
        (4, "no column target"),
        (5, "unit furlong is not known"),
        (6, "the map says rad, but the header of motor [deg] says deg"),
        (7, "did you mean rotor_velocity?"),
        (8, "no key called sgn; did you mean sign?"),
        (10, "no key called speed"),
    ):
        assert any(line.startswith(f"{own}:{number}: ") and said in line for line in lines), said
    assert lines[-1] == f"ecyl inspect: {own}: cannot be used: 6 mistakes, above line by line"
    assert "voltage_q" in told.out  # what is right is read all the same


def test_what_is_odd_but_readable_is_told_and_passes(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A mirrored position and a range no drive has are told with their lines; exit 0."""
    text = GOOD.replace("sign: -1, ", "").replace("unit: mm}", "unit: m}", 1)
    text = text.replace("{field: target_mm, unit: m}", "{field: target_mm, unit: m, scale: 1.5}")
    path, own = table(tmp_path), written(tmp_path, text)
    assert main(["inspect", str(path), "--map", str(own)]) == 0
    told = capsys.readouterr().err
    assert f"{own}:4: signals.reference_position: target_mm ranges from -1500 to 1500 m" in told
    assert f"{own}:5: signals.rod_position: rod_position_m has the wrong sign" in told
    assert "expected sign: -1" in told


def test_a_bags_fields_are_checked_by_topic_and_joint(tmp_path: Path) -> None:
    """Topics, fields and joints that a bag does not hold are each told; the others are read."""
    foreign_mcap(tmp_path / "a.mcap")
    own = written(
        tmp_path,
        """signals:
  reference_position: {topic: /controller/state, field: reference.positions, joint: cylinder}
  rod_position: {topic: /joint_sates, field: position, joint: cylinder}
  rod_velocity: {topic: /joint_states, field: velocity, joint: piston}
  effort: {topic: /joint_states, field: efforts, joint: cylinder}
""",
    )
    found = check_map(tmp_path / "a.mcap", own)
    assert not found.usable
    assert [one.line for one in found.problems if one.fatal] == [3, 4, 5]
    assert [one.name for one in found.signals] == ["reference_position"]
    assert found.signals[0].count == 60


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("signals: [", "not YAML at line"),
        ("[1]", "expected `signals:`"),
        ("signals: {rod_position: slide_mm}\ntime: when\n", "no column when"),
        ("signals: {rod_position: {field: slide_mm, unit: mm}}\nrate: -3\n", "rate: is -3"),
    ],
)
def test_a_map_of_no_use_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], text: str, said: str
) -> None:
    """No YAML, no signals, no instants: exit 2, and the reason is told."""
    assert main(["inspect", str(table(tmp_path)), "--map", str(written(tmp_path, text))]) == 2
    assert said in capsys.readouterr().err
