"""Tolerances of a drive file: stated per constant or for all, else data-sheet practice."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from ecyl_ros.drive.drive_file import (
    drive_from_flat,
    drive_to_flat,
    load_drive,
    read_parameter_file,
    resolve_drive,
)
from ecyl_ros.drive.tolerances import CONSTANTS, constants_of, half_widths, with_constants
from ecyl_ros.errors import InputError

BENCH = {
    key: value
    for key, value in read_parameter_file(resolve_drive("bench")).items()
    if not key.startswith("tolerances")
}


def widths(**stated: Any) -> dict[str, float]:
    """Half widths of the bench drive's constants with these `tolerances`, "__" for a dot."""
    given = {f"tolerances.{key.replace('__', '.')}": value for key, value in stated.items()}
    drive = drive_from_flat({**BENCH, **given}, "drive.yaml")
    return half_widths(constants_of(drive), drive.tolerances)


def test_without_the_key_every_constant_has_its_default() -> None:
    """13 % of 0.73 ohm, half of the viscous friction, nothing of gear ratio and gains."""
    found = widths()
    assert found["motor.resistance"] == pytest.approx(0.13 * 0.73)
    assert found["load.viscous_friction"] == pytest.approx(0.5 * 1e-2)
    exact = {key for key, width in found.items() if width == 0.0}
    assert exact == {"transmission.gear_ratio"} | {k for k in CONSTANTS if "controller" in k}


def test_a_tolerance_is_a_share_or_has_the_constants_unit() -> None:
    """0.1, 10 % and 0.073 ohm are the same of 0.73 ohm."""
    for stated in (0.1, "10 %", "0.073 ohm", "0.1"):
        assert widths(motor__resistance=stated)["motor.resistance"] == pytest.approx(0.073)


def test_all_reaches_what_is_not_stated_by_itself_and_no_setting() -> None:
    """5 % of every constant but the lead, which is exact, and the gains, which are settings."""
    found = widths(all=0.05, transmission__lead="exact", controller__speed__kp=0.1)
    assert found["motor.torque_constant"] == pytest.approx(0.05 * 0.716)
    assert found["transmission.lead"] == 0.0
    assert found["controller.current.kp"] == 0.0
    assert found["controller.speed.kp"] == pytest.approx(0.08)


@pytest.mark.parametrize("text", ["tolerances: exact", "tolerances: {all: exact}"])
def test_exact_leaves_nothing_open(tmp_path: Path, text: str) -> None:
    """One word for all constants."""
    path = tmp_path / "exact.yaml"
    bench = resolve_drive("bench").read_text()
    path.write_text(bench[: bench.index("    tolerances:")] + f"    {text}\n")
    drive = load_drive(path)
    assert not any(half_widths(constants_of(drive), drive.tolerances).values())


@pytest.mark.parametrize(
    ("key", "value", "said"),
    [
        ("tolerances.motor.resistence", 0.1, "did you mean motor.resistance?"),
        ("tolerances.motor.pole_pairs", 0.1, "no constant motor.pole_pairs has a tolerance"),
        ("tolerances.motor.resistance", "0.1 A", "'0.01 ohm'"),
        ("tolerances.motor.resistance", -0.1, "expected exact, a share from 0 to 1"),
        ("tolerances.motor.resistance", 13.0, "expected exact, a share from 0 to 1"),
        ("tolerances.all", "0.1 ohm", "expected exact, a share from 0 to 1"),
        ("tolerances", True, "expected exact, a share from 0 to 1"),
    ],
)
def test_what_cannot_be_is_refused_by_name(key: str, value: object, said: str) -> None:
    """File, key and what was expected, on one line."""
    with pytest.raises(InputError) as refused:
        drive_from_flat({**BENCH, key: value}, "drive.yaml")
    assert str(refused.value).startswith(f"drive.yaml: {key}") and said in str(refused.value)


def test_tolerances_survive_the_way_through_flat_parameters() -> None:
    """What the nodes are given is what the file said."""
    stated = {"tolerances.all": 0.05, "tolerances.motor.resistance": "0.05 ohm"}
    drive = drive_from_flat({**BENCH, **stated}, "drive.yaml")
    again = drive_from_flat(drive_to_flat(drive), "node")
    assert half_widths(constants_of(again), again.tolerances) == half_widths(
        constants_of(drive), drive.tolerances
    )


def test_other_constants_keep_the_ratio_of_stiffness_segments() -> None:
    """A stiffer first segment stiffens all; gains are reached by their dotted names."""
    drive = load_drive("paper")
    first, *others = drive.transmission.stiffness
    changed = with_constants(
        drive, {"transmission.stiffness": 2.0 * first, "controller.speed.kp": 3.0}
    )
    assert changed.transmission.stiffness == pytest.approx([2.0 * one for one in (first, *others)])
    assert changed.controller.speed.kp == 3.0
    assert changed.controller.speed.ki == drive.controller.speed.ki
