"""A drive file without clearance and stiffness: they are found, and what that costs is said."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml
from sheets import exact

from ecyl_ros.drive.drive_file import drive_to_flat, load_drive
from ecyl_ros.gap.diagnose import diagnose
from ecyl_ros.gap.report.terminal import summary
from ecyl_ros.gap.study.case import Case
from ecyl_ros.gap.study.cylinder.cases import record_case
from ecyl_ros.gap.twin.closer import write_twin

LEFT_OUT = ("transmission.backlash", "transmission.stiffness", "transmission.contact_damping")


@pytest.mark.slow
def test_friction_is_named_beside_a_coupling_that_is_left_out(tmp_path: Path) -> None:
    """The right cause alone, clearance and stiffness of the machine in their intervals, both in the
    closer twin; their faults are not named, and a note says so."""
    true = exact("bench")
    effects = {"rotor_coulomb_friction": {"coulomb_nm": 0.3}}
    recording = record_case(Case(0, 8, "single", effects), true).slice(0.0, 4.0)
    given = {key: value for key, value in drive_to_flat(true).items() if key not in LEFT_OUT}
    nominal, twin = tmp_path / "nominal.yaml", tmp_path / "twin.yaml"
    nominal.write_text(yaml.safe_dump({"/**": {"ros__parameters": given}}))
    result = diagnose(recording, load_drive(nominal))
    assert [one.effect for one in result.causes] == ["rotor_coulomb_friction"]
    assert result.verdict == "explained"
    found = {one.parameter: one for one in result.sheet}
    assert set(found) == set(LEFT_OUT) and not any(one.stated for one in found.values())
    for key, value in (
        (LEFT_OUT[0], true.transmission.backlash),
        (LEFT_OUT[1], true.transmission.stiffness[0]),
    ):
        assert found[key].low <= value <= found[key].high
        assert found[key].value == pytest.approx(value, rel=0.02)
    assert any("a wrong backlash cannot be seen" in one for one in result.notes)
    assert "left out" in summary(result)
    write_twin(result, nominal, twin)
    written = load_drive(twin)
    assert written.transmission.stiffness[0] == pytest.approx(found[LEFT_OUT[1]].value, rel=1e-6)
    assert written.left_out == () and set(written.effects) == set(effects)
