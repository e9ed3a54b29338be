"""A sure cause is named although something small beside it cannot be told apart."""

from __future__ import annotations

from ecyl_ros.drive.drive_file import load_drive
from ecyl_ros.gap.blind.cases import Case, record_case
from ecyl_ros.gap.diagnose import diagnose


def test_what_cannot_be_told_apart_does_not_take_a_sure_cause_along() -> None:
    """A voltage limit of another make of machine is named, two effects that fit alike are not."""
    drive = load_drive("bench")
    true = {"voltage_limit": {"voltage_v": 2.586485128454045}}
    found = diagnose(record_case(Case(0, 866944933, "single", true), drive), drive)
    assert [one.effect for one in found.causes] == ["voltage_limit"]
    assert found.causes[0].confidence > 0.9
    (value,) = found.causes[0].parameters
    assert value.low < true["voltage_limit"]["voltage_v"] < value.high
    assert any("one as well as the other" in note for note in found.notes)
