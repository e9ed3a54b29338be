"""Map files: what they say, and what is refused."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from ecyl_ros.errors import InputError
from ecyl_ros.recording import SIGNALS
from ecyl_ros.recording.map import MAPPED, map_yaml
from ecyl_ros.recording.map_file import load_map, parse_map
from ecyl_ros.recording.signals import FOREIGN_SIGNALS
from ecyl_ros.recording.units import UNITS, dimension_of, in_si

FULL = """
schema: ecyl.map/1
stamp: header
joint: cylinder
gap: 0.5
signals:
  reference_position: {topic: /state, field: reference.positions, unit: mm}
  rod_position: {topic: /joint_states, field: position, sign: -1, joint: rod}
  rotor_velocity: {topic: /m, field: "velocity[0]", unit: rpm, scale: 0.1, offset: 3, stamp: bag}
  effort: "/joint_states.effort[2]"
"""


def written(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "m.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def test_a_map_says_where_each_signal_stands(tmp_path: Path) -> None:
    """Topic, field, joint, unit and stamp are those of the entry, else those of the whole map."""
    found = load_map(written(tmp_path, FULL))
    reference, rotor, rod, effort = found.signals
    assert (reference.topic, reference.field) == ("/state", "reference.positions")
    assert (reference.joint, rod.joint) == ("cylinder", "rod")
    assert (reference.stamp, rotor.stamp) == ("header", "bag")
    assert rod.target == "rod_position_m"
    assert effort.field == "/joint_states.effort[2]"
    assert effort.target == "rotor_torque_nm"
    assert found.gap_s == 0.5


def test_values_become_si(tmp_path: Path) -> None:
    """100 counts of 0.1 rpm, offset by 3 rpm, are 13 rpm, that is 13 * 2 pi / 60 rad/s."""
    found = load_map(written(tmp_path, FULL))
    rotor = found.of("rotor_velocity_rad_per_s")
    rod = found.of("rod_position_m")
    assert rotor is not None and rod is not None
    np.testing.assert_allclose(rotor.in_si(np.array([100.0])), 13.0 * math.tau / 60.0)
    np.testing.assert_array_equal(rod.in_si(np.array([2.0])), [-2.0])


@pytest.mark.parametrize(
    ("unit", "field"), [("N m", "rotor_torque_nm"), ("N", "rod_force_n"), ("mA", "current_q_a")]
)
def test_the_unit_of_an_effort_says_what_it_is(unit: str, field: str) -> None:
    """An effort in N m is the motor's torque, in N the rod's force, in A the current."""
    found = parse_map({"signals": {"effort": {"field": "u", "unit": unit}}}, "m")
    assert found.signals[0].target == field


def test_each_signal_can_be_mapped() -> None:
    """Every signal of a recording has a name in a map, that of its field without the unit."""
    targets = {field for fields in MAPPED.values() for field in fields.values()}
    assert targets == set(SIGNALS) | set(FOREIGN_SIGNALS)
    for name, fields in MAPPED.items():
        for dimension, field in fields.items():
            assert name in ("effort", "mode") or field.startswith(f"{name}_")
            assert next(iter(UNITS[dimension])) == (SIGNALS | FOREIGN_SIGNALS)[field]


def test_units_have_one_meaning() -> None:
    """No unit stands in two dimensions, the first of each is 1, and usual spellings agree."""
    names = [name for units in UNITS.values() for name in units]
    assert len(names) == len(set(names))
    assert all(next(iter(units.values())) == 1.0 for units in UNITS.values())
    assert {in_si(u) for u in ("N m", "Nm", "N*m", "N·m", "N-m")} == {1.0}
    assert in_si("µm") == 1e-6
    assert in_si("rev") == pytest.approx(360 * in_si("deg"))
    assert in_si("lbf in") == pytest.approx(in_si("lbf") * in_si("in"))
    assert dimension_of("furlong") is None


def test_a_written_map_reads_the_same(tmp_path: Path) -> None:
    """`map_yaml` and `load_map` undo each other, comment and all."""
    first = load_map(written(tmp_path, FULL))
    again = load_map(written(tmp_path, map_yaml(first, "proposed\nsee to it")))
    assert again.signals == first.signals
    assert again.gap_s == first.gap_s
    timed = parse_map(
        {"signals": {"effort": "u"}, "time": {"field": "t", "unit": "ms", "scale": 0.5}}, "m"
    )
    assert load_map(written(tmp_path, map_yaml(timed))).time == timed.time


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "expected `signals:`"),
        ("[1, 2]", "expected `signals:`"),
        ("signals: {}", "missing or empty"),
        ("signal: {}", "no key called signal; did you mean signals?"),
        ("signals: {rod_positon: x}", "did you mean rod_position?"),
        ("signals: {rod_position: 3}", "signals.rod_position: is 3"),
        ("signals: {rod_position: {unit: m}}", "signals.rod_position: no field"),
        ("signals: {rod_position: {field: x, unit: rad}}", "is rad, expected one of m, cm"),
        ("signals: {rod_position: {field: x, sign: 2}}", "sign: is 2, expected 1 or -1"),
        ("signals: {rod_position: {field: x, sign: true}}", "sign: is True"),
        ("signals: {rod_position: {field: x, scale: 0}}", "scale: is 0"),
        ("signals: {rod_position: {field: x, scale: .nan}}", "scale: is nan"),
        ("signals: {rod_position: {field: x, offset: wide}}", "offset: is wide"),
        ("signals: {rod_position: {field: x, stamp: wall}}", "stamp is wall"),
        ("signals: {rod_position: {field: x, joint: 3}}", "joint: is 3, expected text"),
        ("signals: {rod_position: {feild: x}}", "did you mean field?"),
        ("signals: {rod_position: x, rod_position: y}", "rod_position appears twice"),
        ("signals: {effort: x, rotor_torque: y}", "both give rotor_torque_nm"),
        ("{signals: {effort: x}, time: t, rate: 5}", "both time and rate"),
        ("{signals: {effort: x}, time: {field: t, unit: m}}", "time.unit: is m"),
        ("{signals: {effort: x}, rate: -5}", "rate: is -5, expected a number above 0"),
        ("{signals: {effort: x}, schema: ecyl.map/9}", "expected ecyl.map/1"),
        ("signals: [", "not YAML at line 1"),
    ],
)
def test_a_bad_map_is_refused_in_one_line(tmp_path: Path, text: str, said: str) -> None:
    """Whatever is wrong is named, with the file, on one line."""
    path = written(tmp_path, text)
    with pytest.raises(InputError) as raised:
        load_map(path)
    message = str(raised.value)
    assert said in message
    assert message.startswith(str(path))
    assert "\n" not in message
