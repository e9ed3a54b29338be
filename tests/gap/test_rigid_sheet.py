"""A rigid drive's data sheet: what its tolerances allow is no cause, what they do not is one."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from rigid_machines import LINEAR, motion, recorded

from ecyl_ros.drive.rigid.machine_file import machine_from_flat
from ecyl_ros.errors import InputError
from ecyl_ros.gap.diagnose import diagnose

M = motion(0.05)
FILE = {"drive.kind": "rigid", "drive.output": "linear", "load.mass": 20.0}


def judged(mass: float, tolerance: float | str, friction: float = 0.0):
    """A mass of 20 kg on the sheet, in truth another, with Coulomb friction or without."""
    machine = dataclasses.replace(LINEAR, tolerances={"load.mass": tolerance})
    effort = mass * M.a + friction * np.tanh(M.v / 1e-4)
    return diagnose(recorded(M, effort, machine, 0.3, 1e-6), machine)


def test_a_mass_within_its_tolerance_is_no_cause() -> None:
    """5 % more mass than the sheet says, which holds it to 10 %: within the sheet, and found."""
    result = judged(21.0, 0.1)
    assert result.verdict == "within_sheet" and result.causes == () and result.block is None
    (mass,) = result.sheet
    assert mass.parameter == "load.mass" and mass.low <= 21.0 <= mass.high
    assert mass.pull == pytest.approx(0.5, abs=0.02) and mass.tolerance == pytest.approx(2.0)


@pytest.mark.parametrize(("mass", "tolerance"), [(21.0, "exact"), (21.0, 0.01), (26.0, 0.1)])
def test_a_mass_that_leaves_its_tolerance_is_a_cause(mass, tolerance) -> None:
    """The same 5 % where the sheet is exact or finer, and 30 % where it holds to 10 %."""
    result = judged(mass, tolerance)
    assert [one.effect for one in result.causes] == ["load_inertia_error"]
    assert result.causes[0].parameters[0].value == pytest.approx(mass, rel=0.01)


def test_a_fault_beside_a_mass_off_its_sheet_is_named_alone() -> None:
    """Friction is sized as if the mass were known, and the mass is no cause beside it."""
    result = judged(21.0, 0.1, friction=9.0)
    assert [one.effect for one in result.causes] == ["load_coulomb_friction"]
    assert result.causes[0].parameters[0].value == pytest.approx(9.0, rel=0.02)


def test_a_mass_far_off_its_sheet_below_the_noise_is_a_gap() -> None:
    """A third more mass that noise hides sample by sample, and the whole recording shows: named,
    and its size found. The same noise beside a sound mass: no gap."""
    tolerances = {"load.mass": 0.04, "load.viscous_friction": 0.04}
    machine = dataclasses.replace(LINEAR, viscous=300.0, tolerances=tolerances)
    found = {}
    for mass in (20.3, 26.0):
        effort = mass * M.a + 300.0 * M.v
        found[mass] = diagnose(recorded(M, effort, machine, 12.0, 1e-6), machine)
    assert found[20.3].verdict == "no_gap"
    (cause,) = found[26.0].causes
    assert cause.effect == "load_inertia_error" and found[26.0].verdict == "explained"
    assert cause.parameters[0].low <= 26.0 <= cause.parameters[0].high


def test_a_rigid_file_states_tolerances() -> None:
    """Shares, units, exact; a constant that a rigid drive does not have is refused by name."""
    machine = machine_from_flat({**FILE, "tolerances.load.mass": "0.5 kg"}, "axis.yaml")
    assert machine.half_widths() == {"load.mass": 0.5}
    assert machine_from_flat(FILE, "axis.yaml").half_widths() == {"load.mass": pytest.approx(2.0)}
    assert machine_from_flat({**FILE, "tolerances": "exact"}, "a").half_widths()["load.mass"] == 0.0
    with pytest.raises(InputError, match=r"axis\.yaml: tolerances\.motor\.resistance"):
        machine_from_flat({**FILE, "tolerances.motor.resistance": 0.1}, "axis.yaml")
